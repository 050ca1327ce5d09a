. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
printf 'P6\n1 1\n255\nabc' > b.ppm
qs-compare a.ppm b.ppm
