cp "$QS_DATA/tiny.qs" .
qs-info --json --report report.json tiny.qs > out.json
cmp report.json out.json
# On standard output there is one of them only.
qs-info --report - tiny.qs | cmp - out.json
