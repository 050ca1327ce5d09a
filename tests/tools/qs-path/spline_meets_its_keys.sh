qs-path orbit --bounds 0,0,0,1 --frames 5 -o keys.jsonl
qs-path spline keys.jsonl --closed --frames 50 | sed -n '1~10p' | cut -d , -f 1-10 > met
cut -d , -f 1-10 keys.jsonl | cmp - met
