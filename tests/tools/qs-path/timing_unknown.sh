qs-path spline keys.jsonl --timing slow
