# Keys that come from the file that the path would replace.
qs-path orbit --bounds 0,0,0,1 --frames 3 -o keys.jsonl
qs-path spline - -o keys.jsonl < keys.jsonl
echo "exit $?"
qs-path spline - -o path.jsonl --report keys.jsonl < keys.jsonl
echo "exit $?"
wc -l < keys.jsonl
ls
