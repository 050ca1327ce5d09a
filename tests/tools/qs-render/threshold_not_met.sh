# How many frames are coarser than was asked for is said at the end, once: of a path towards the model the later ones.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 40 | qs-build --quiet - -o model.qs
for z in 1000 500 5 4; do echo "{\"eye\":[0,0,$z],\"target\":[0,0,0]}"; done > path.jsonl
draw() { qs-render model.qs --path path.jsonl --resolution 320,240 -o frame-%d.ppm "$@"; }
draw --threshold 0.5
draw --threshold 0
draw --threshold 0.5 --quiet
draw --threshold 0.5 --splat circle
draw --threshold-diameter 0.5
draw --threshold 40
draw
head -c 2048 model.qs > prefix.qs
qs-render prefix.qs --threshold 1 -o still.ppm 2>&1 | grep -c warning
