. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
echo hello > b.png
qs-compare a.ppm b.png
