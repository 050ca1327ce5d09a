head -c 1000 "$QS_DATA/tiny.qs" > cut.qs
qs-info cut.qs
