printf '%s\n' '{"eye":[0,0,5],"target":[0,0,0],"t":1}' '{"eye":[0,0,6],"target":[0,0,0],"t":1}' > keys.jsonl
qs-path spline keys.jsonl --timing keys
