. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
qs-compare a.ppm nothing.png
