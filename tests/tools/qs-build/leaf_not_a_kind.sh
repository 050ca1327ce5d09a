qs-build "$QS_DATA/tiny.ply" --leaf square -o tiny.qs
