qs-path orbit --bounds 0,0,0,1 --threads 1 > 1.jsonl
qs-path orbit --bounds 0,0,0,1 --threads 2 -o 2.jsonl
cmp 1.jsonl 2.jsonl && wc -l < 1.jsonl
