. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01100110
qs-compare a.ppm a.ppm --min-psnr 100 --min-ssim 1 --min-iou 1 --max-growth 0 --max-holes 0 --max-difference 0
