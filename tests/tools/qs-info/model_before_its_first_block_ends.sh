head -c 2000 "$QS_DATA/tiny.qs" > cut.qs
qs-info cut.qs
