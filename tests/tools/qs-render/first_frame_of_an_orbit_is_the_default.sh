"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > mesh.ply
qs-build mesh.ply -o model.qs
qs-path orbit model.qs --frames 1 --resolution 320,240 -o path.jsonl
qs-render model.qs --resolution 320,240 -o default.ppm
qs-render model.qs --resolution 320,240 --path path.jsonl -o orbit.ppm
cmp default.ppm orbit.ppm
qs-path orbit model.qs --frames 1 --resolution 320,240 --azimuth 40 --elevation -20 --fovy 50 --up z -o path.jsonl
qs-render model.qs --resolution 320,240 --camera-azimuth-angle 40 --camera-elevation-angle -20 \
    --camera-view-angle 50 --camera-view-up 0,0,1 -o default.ppm
qs-render model.qs --resolution 320,240 --path path.jsonl -o orbit.ppm
cmp default.ppm orbit.ppm
