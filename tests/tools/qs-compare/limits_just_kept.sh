. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01110110
picture b.ppm 01101110
qs-compare a.ppm b.ppm --min-psnr 14 --min-ssim 0.1 --min-iou 0.5 --max-growth 20 --max-holes 1 --max-difference 100 > /dev/null
