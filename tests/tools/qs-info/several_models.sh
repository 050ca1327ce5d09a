cp "$QS_DATA/tiny.qs" a.qs
cp a.qs b.qs
qs-info missing.qs a.qs b.qs | grep -n -e '^$' -e qs -e vertices
