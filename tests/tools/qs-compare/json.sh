. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
picture b.ppm 01101110
qs-compare a.ppm b.ppm --json --min-psnr 60 --report report.jsonl
echo "status $?"
cat report.jsonl
qs-compare a.ppm b.ppm --report - | cmp - report.jsonl
