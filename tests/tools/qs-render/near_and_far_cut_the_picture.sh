# What is before near or behind far is not drawn: an octahedron of radius 1 and 3, seen along x.
qs-build --quiet "$QS_DATA/tiny.ply" -o model.qs
path() { echo "{\"eye\":[9,0.5,0.5],\"target\":[0,0,0]$1}"; }
draw() { # NAME, camera's further keys
    path "$2" | qs-render model.qs --threshold 0 --resolution 64,48 --path - -o "$1.ppm" --report - |
        grep -o '"splats":[0-9]*'
}
draw all ''
draw wide ',"near":0.5,"far":200'
cmp all.ppm wide.ppm && echo 'wide limits change nothing'
draw before ',"near":0.1,"far":1'
draw behind ',"near":50'
cmp before.ppm behind.ppm && echo 'beyond the limits is nothing'
draw half ',"far":9'
cmp -s all.ppm half.ppm || echo 'a half is another picture'
