. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01100110
qs-compare a.ppm a.ppm --json
