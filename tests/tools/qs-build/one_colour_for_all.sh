awk '{ if (NF == 6) print $1, $2, $3, 10, 20, 30; else print }' "$QS_DATA/tiny.ply" > tiny.ply
qs-build tiny.ply -o tiny.qs
qs-info tiny.qs | grep -e colour -e 'left out'
