qs-build --no-colour "$QS_DATA/tiny.ply" -o tiny.qs
qs-info tiny.qs | grep -e colour -e 'left out'
