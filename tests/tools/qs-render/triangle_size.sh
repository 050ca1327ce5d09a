# Leaves that are large are triangles, those that are not are splats; all of them, none of them.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
qs-build --quiet mesh.ply --leaf triangle -o model.qs
draw() { qs-render model.qs --resolution 320,240 --threshold 0.5 --quiet --report - "$@"; }
counts() { grep -oE '"(splats|triangles)":[0-9]*' | sed -E 's/:0$/: none/; s/:[1-9].*/: some/'; }
for size in 0 8 1000; do
    echo "from $size px:"
    draw --triangle-size "$size" -o "from-$size.ppm" | counts
done
draw -o default.ppm > default.json
draw --triangle-size 4 -o four.ppm > four.json
cmp default.ppm four.ppm
levels=$(qs-info --json model.qs | grep -o '"level_count":[0-9]*' | cut -d: -f2)
qs-info --cut "$levels" model.qs -o leaves.ply
for splat in square circle ellipse smooth; do
    draw --reference leaves.ply --splat "$splat" --triangle-size 0 | grep -o '"holes":0,'
done
qs-render model.qs --camera-view-angle 8 --explain | grep triangles | sed 's/[0-9]\{2,\}/N/'
