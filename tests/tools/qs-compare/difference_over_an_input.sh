. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
cp a.ppm b.png
qs-compare a.ppm b.png --difference ./b.png
echo "status $?" >&2
cmp a.ppm b.png
