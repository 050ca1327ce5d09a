echo '{"eye":[0,0,5],"target":[0,0,0]}' > keys.jsonl
qs-path spline keys.jsonl
