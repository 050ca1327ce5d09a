# A model that becomes shorter while it is drawn ends the run with a message, and leaves no half of a picture.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 100 > mesh.ply
qs-build --quiet mesh.ply -o model.qs
qs-path orbit model.qs --frames 60 -o path.jsonl
# What nobody reads yet holds up the rest.
{ qs-render model.qs --path path.jsonl --threshold 0 --resolution 320,240 -o - --depth "depth-%d.pfm" 2> said; echo "exit $?" > status; } |
    { head -c 1000 > begin; truncate -s 65536 model.qs; cat > rest; }
cat status said
head -c 9 begin
echo
find . -name 'depth-*.pfm' -size -307200c
ls -A | grep -c tmp || true
