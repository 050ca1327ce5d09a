qs-build - -o - < "$QS_DATA/tiny.ply" | cmp - "$QS_DATA/tiny.qs"
