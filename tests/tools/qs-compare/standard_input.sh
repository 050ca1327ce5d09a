. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
picture b.ppm 01101110
qs-compare - b.ppm < a.ppm
