qs-build --block-size 3000 "$QS_DATA/tiny.ply" -o tiny.qs
