printf '%s\n' '{"eye":[0,0,5],"target":[0,0,0]}' '' '{"eye":[0,0],"target":[0,0,0]}' > keys.jsonl
qs-path spline keys.jsonl
