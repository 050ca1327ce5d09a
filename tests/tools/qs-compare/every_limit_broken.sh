. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
picture b.ppm 01101110
qs-compare a.ppm b.ppm --min-psnr 60 --min-ssim 0.999 --min-iou 0.99 --max-growth 0.5 --max-holes 0 --max-difference 3 > /dev/null
