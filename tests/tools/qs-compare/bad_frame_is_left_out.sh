. "$QS_SOURCE/tests/tools/picture"
mkdir one other
for i in 0 1; do picture one/frame-000$i.ppm 01100110; done
cp one/* other
printf 'P6\n4 2\n255\nabc' > one/frame-0000.ppm
qs-compare one other
