qs-path orbit --bounds 0,0,0,1 --frames 3 -o keys.jsonl
qs-path spline keys.jsonl -o ./keys.jsonl
status=$?
wc -l < keys.jsonl
exit $status
