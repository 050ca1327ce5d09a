. "$QS_SOURCE/tests/tools/picture"
mkdir one other
picture one/frame-0000.ppm 01100110
picture one/frame-0001.ppm 01100120
picture one/frame-0002.ppm 01130110
for i in 0 1 2; do picture other/frame-000$i.ppm 01100110; done
echo notes > one/notes.txt
qs-compare one other --max-holes 0 --min-psnr 20 --difference differences
echo "status $?"
ls differences
qs-compare differences/frame-0000.ppm.png differences/frame-0000.ppm.png > /dev/null
