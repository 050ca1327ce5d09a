qs-info - < "$QS_DATA/tiny.qs" | head -n 2
