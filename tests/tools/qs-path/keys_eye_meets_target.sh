printf '%s\n' '{"eye":[0,0,1],"target":[0,0,0]}' '{"eye":[0,0,0],"target":[0,0,1]}' > keys.jsonl
qs-path spline keys.jsonl --frames 3
