# Transforms that cannot be drawn, on the command line (status 2) and in files (status 1).
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 | qs-build - -o model.qs
try() {
    qs-render "$@" -o frame.png 2>&1 | head -n 1
    echo "status ${PIPESTATUS[0]}"
}
try model.qs@1,2
try model.qs@1,2,3,0
try model.qs@1,2,3,-1
try model.qs@1,2,3,1e999
try model.qs@1,0,0,0,0,2,0,0,0,0,1,0,0,0,0,1
try model.qs@1,0,0,0,0,1,0,0,0,0,1,0,0,0,1,1
try model.qs@1,,3
try model.qs@,1,2,3
try model.qs@1,2,3,
try model.qs@1,2,,
try model.qs@nan,0,0
try model.qs@1,inf,0
try "model.qs@1;2;3"
try "model.qs@1, 2, x"
try model.qs@
try model.qs@turned.txt
try missing.qs@nan,0,0
try missing.qs@1,2,3
try model.qs@missing.xf
echo "1 2 three" > words.xf
try model.qs@words.xf
: > empty.xf
try model.qs@empty.xf
head -c 100000 /dev/zero > long.xf
try model.qs@long.xf
try - -
try model.qs model.qs --reference model.ply --report -
try model.qs@1,2,3 --reference model.ply --report -
try model.qs model.qs@1,1,1 missing.qs
try model.qs --occlusion sometimes
echo 1,2,3 > frame.xf
qs-render model.qs@frame.xf --format rgb -o frame.xf 2>&1 | head -n 1
# The end of a name.
cp model.qs model.qs@home
qs-render model.qs@home --resolution 8,6 --format rgb -o - | wc -c
printf '1,\n2 , 3\n' > right.xf
qs-render model.qs@right.xf --resolution 8,6 --format rgb -o - | wc -c
