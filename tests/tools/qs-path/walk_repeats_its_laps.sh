qs-path walk --bounds 0,0,0,1 --frames 96 | sed 's/,"t".*//' > walk
head -n 48 walk > first
tail -n 48 walk | cmp - first && sort -u walk | wc -l
