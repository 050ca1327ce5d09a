qs-build "$QS_DATA/bumpy.qs" --compress -o small.qs --quiet
qs-render "$QS_DATA/bumpy.qs" --resolution 160,120 -o plain.png --quiet
qs-render small.qs --resolution 160,120 -o small.png --quiet
cmp plain.png small.png
qs-path orbit small.qs --frames 3 | cmp - <(qs-path orbit "$QS_DATA/bumpy.qs" --frames 3)
