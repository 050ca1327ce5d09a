cp "$QS_DATA/tiny.qs" .
qs-info tiny.qs
