cp "$QS_DATA/tiny.qs" .
qs-build tiny.qs --compress --block-size 4K -o out.qs
