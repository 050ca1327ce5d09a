cp "$QS_DATA/tiny.qs" .
qs-info --json --report report.json tiny.qs > out.json
cmp report.json out.json
