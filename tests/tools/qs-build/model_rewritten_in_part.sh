head -c 3500 "$QS_DATA/bumpy.qs" > part.qs
qs-build part.qs --compress -o out.qs
