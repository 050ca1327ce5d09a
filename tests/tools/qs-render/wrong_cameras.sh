# What can be told only with the model and the path.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 10 > mesh.ply
qs-build mesh.ply -o model.qs
qs-path orbit model.qs --frames 2 -o path.jsonl
: > empty.jsonl
try() {
    qs-render model.qs "$@" 2>&1 | head -n 1
}
try -o frame.png --camera-position 1,2,3 --camera-azimuth-angle 20
try -o frame.png --camera-view-up 0,0,0
try -o frame.png --path path.jsonl
try --depth depth.pfm --path path.jsonl
try -o frame-%d.png --path empty.jsonl
ls -A
