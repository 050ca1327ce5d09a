qs-path orbit --bounds 0,0,0,1 --frames 100000 | head -n 1 | wc -l
echo "${PIPESTATUS[0]}"
