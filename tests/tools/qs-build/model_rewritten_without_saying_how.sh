cp "$QS_DATA/tiny.qs" .
qs-build tiny.qs -o out.qs
