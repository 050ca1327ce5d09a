# Frames one after the other, in each format, on standard output.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 10 > mesh.ply
qs-build mesh.ply -o model.qs
qs-path orbit model.qs --frames 3 --fps 30 -o path.jsonl
draw() {
    qs-render model.qs --path path.jsonl --resolution 64,48 "$@"
}
draw -o - | head -n 1
draw -o - | wc -c
draw -o - --fps 23.976 | head -n 1
draw -o - --format rgb | wc -c
draw -o - --format ppm | head -n 2
draw -o - --format ppm | wc -c
draw -o frame-%02d.png --depth depth-%d.pfm
ls frame* depth*
head -n 3 depth-0.pfm
draw -o all.y4m
draw -o - | cmp - all.y4m
