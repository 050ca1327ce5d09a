# The same camera by options and by a path.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > mesh.ply
qs-build mesh.ply -o model.qs
echo '{"eye":[2,1,3],"target":[0.1,0,0],"up":[1,0,0],"fovy":35}' |
    qs-render model.qs --resolution 320,240 --path - -o path.ppm
qs-render model.qs --resolution 320,240 --camera-position 2,1,3 --camera-focal-point 0.1,0,0 \
    --camera-view-up 1,0,0 --camera-view-angle 35 -o options.ppm
cmp path.ppm options.ppm
