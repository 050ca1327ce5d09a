. "$QS_SOURCE/tests/tools/picture"
mkdir one other
for i in 0 1 2; do picture one/frame-000$i.ppm 01100110; done
picture other/frame-0001.ppm 01100110
qs-compare one other
echo "status $?" >&2
qs-compare other one
