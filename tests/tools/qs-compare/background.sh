. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 33333111
picture b.ppm 33331111
qs-compare a.ppm b.ppm --max-growth 0 > /dev/null && echo "grey counts as covered"
qs-compare a.ppm b.ppm --background 100,100,100 --max-growth 5 > /dev/null
