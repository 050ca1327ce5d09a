# The camera that --verbose prints is that of the picture, also of one at an angle.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 5 > mesh.ply
qs-build mesh.ply -o model.qs
for options in "" "--camera-azimuth-angle 40 --camera-view-angle 12"; do
    qs-render model.qs --resolution 64,48 $options -o default.png --verbose 2>&1 |
        sed -n 's/^qs-render: camera: //p' > path.jsonl
    grep -o '"fovy":[0-9]*' path.jsonl
    qs-render model.qs --resolution 64,48 --path path.jsonl -o again.png
    cmp default.png again.png && echo 'the same picture'
done
