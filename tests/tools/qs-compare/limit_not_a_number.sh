. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
qs-compare a.ppm a.ppm --min-psnr nan
