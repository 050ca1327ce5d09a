qs-build "$QS_DATA/tiny.ply"
