# Tiles, put together row by row, are the picture, for each kind of splat and with samples.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
for options in "--splat square" "--splat circle" "--splat ellipse" "--splat smooth" "--samples 4 --key-light 1,1,1"; do
    draw="qs-render model.qs --resolution 101,67 --format rgb -o - $options"
    $draw > whole.rgb
    for y in 0 1 2; do
        for x in 0 1; do $draw --tile $x,$y/2,3 > "$x.rgb"; done
        # Columns begin at 0 and 50, rows at 0, 22 and 44.
        paste -d '' <(od -An -v -tx1 -w150 0.rgb) <(od -An -v -tx1 -w153 1.rgb)
    done > tiles.txt
    cmp <(od -An -v -tx1 -w303 whole.rgb) tiles.txt && echo "same: $options"
done
# Of a picture that is larger than what can be drawn at once.
qs-render model.qs --resolution 32768,32768 --tile 256,256/512,512 -o tile.png --depth tile.pfm && head -n 2 tile.pfm
