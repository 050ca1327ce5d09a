. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
picture b.ppm 01101110
qs-compare a.ppm b.ppm --difference difference.png > /dev/null
printf 'P6\n4 2\n255\n\0\0\0\0\0\0\0\0\0\377\0\0\0\0\377\0\0\0\0\0\0\0\0\0' > expected.ppm
qs-compare difference.png expected.ppm --max-difference 0
