. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
mkdir folder
qs-compare a.ppm folder
