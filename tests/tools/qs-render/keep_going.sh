# A camera that cannot be drawn stops the run before anything is written, or is left out and reported.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
qs-build --quiet mesh.ply -o model.qs
qs-path orbit model.qs --frames 4 -o good.jsonl
{ head -n 2 good.jsonl; echo '{"eye":[1,2,3],"target":[1,2,3]}'; echo 'oops'; tail -n 2 good.jsonl; } > path.jsonl
draw() { qs-render model.qs --resolution 320,240 "$@"; }
draw --path path.jsonl -o "%d.ppm"
echo "exit $?"
ls
draw --path path.jsonl -o "%d.ppm" --keep-going --report report.jsonl
echo "exit $?"
ls
cut -c 1-60 report.jsonl | grep -v '"ms"'
draw --path good.jsonl -o "good-%d.ppm" --keep-going
echo "exit $?"
cmp good-1.ppm 1.ppm && cmp good-2.ppm 4.ppm && cmp good-3.ppm 5.ppm && echo "the others are as without it"

# A stream goes on; its rate is that of the cameras that are right.
draw --path path.jsonl -o - --keep-going 2> said > stream
grep -ac FRAME stream
head -n 1 stream
grep -c . said
# Only wrong cameras.
echo '{}' | draw --path - -o "none-%d.ppm" --keep-going
echo "exit $?"

# What cannot be written ends the run, and is not taken for frames that cannot be drawn.
mkdir -p folder/2.ppm
draw --path good.jsonl -o "folder/%d.ppm" --keep-going > said 2>&1
echo "exit $?"
grep -c 'is a directory' said

# A damaged block: frames that do not need it are drawn.
size=$(stat -c %s model.qs)
printf x | dd of=model.qs bs=1 seek=$((size - 900)) conv=notrunc status=none
{
    echo '{"eye":[0,0,1000],"target":[0,0,0]}'
    echo '{"eye":[0,0,4],"target":[0,0,0]}'
    echo '{"eye":[0,0,1000],"target":[0,0,0]}'
} > path.jsonl
draw --path path.jsonl --threshold 0.5 --keep-backfaces -o "damaged-%d.ppm" --keep-going 2>&1 | sed 's/checksum.*//'
ls damaged-*
cmp damaged-0.ppm damaged-2.ppm

# Of a frame that fails there is nothing: no coarser refinement, no other eye.  The block is one of fine nodes.
head -n 2 path.jsonl > two.jsonl
draw --path two.jsonl --threshold 0.5 --keep-backfaces --refine --keep-going --report report.jsonl 2> /dev/null
sed -E 's/.*"frame":([0-9]*),.*"(refinement|error)":.*/\1 \2/' report.jsonl | uniq -c
# Two eyes that see the model's two halves, of which the left one is whole.
{
    echo '{"eye":[0,0,1000],"target":[0,0,0]}'
    echo '{"eye":[0,0,4],"target":[0,0,-96],"fovy":10}'
} > near.jsonl
draw --path near.jsonl --threshold 0.5 --stereo --eye-angle 0.7 -o "eye-%d-%s.ppm" --keep-going --report report.jsonl 2> /dev/null
sed -E 's/.*"frame":([0-9]*),.*"(eye|error)":.*/\1 \2/' report.jsonl
qs-render model.qs --camera-position=-0.6,0,4 --camera-focal-point=-0.6,0,0 --camera-view-angle 10 --threshold 0.5 -o left.ppm
ls ./eye-*.ppm left.ppm

# The first frame that can be drawn is explained.
{ echo 'oops'; cat near.jsonl; } > path.jsonl
draw --path path.jsonl --explain --keep-going 2>&1 | sed -n '1p;2s/ .*//p'
echo 'oops' | draw --path - --explain --keep-going
echo "exit $?"
draw --path path.jsonl --explain
echo "exit $?"
