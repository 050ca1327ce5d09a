qs-path spline keys.jsonl --timing keys --frames 10
