qs-path walk --bounds 1,2,3,4 --frames 24 -o walk.jsonl --report -
qs-path spline walk.jsonl -o spline.jsonl --report -
