cp "$QS_DATA/tiny.qs" .
qs-info --json tiny.qs
