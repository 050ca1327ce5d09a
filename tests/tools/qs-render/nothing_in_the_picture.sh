# A warning, where no picture has anything in it; a path that begins beside the model has one that does.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 5 > mesh.ply
qs-build mesh.ply -o model.qs
qs-render model.qs --resolution 64,48 --camera-position 0,0,9 --camera-focal-point 0,0,20 -o away.png
qs-render model.qs --resolution 64,48 --camera-position 0,0,9 --camera-focal-point 0,0,20 -o away.png --quiet
printf '{"eye":[0,0,9],"target":[0,0,20],"up":[0,1,0],"fovy_deg":30}\n{"eye":[0,0,9],"target":[0,0,0],"up":[0,1,0],"fovy_deg":30}\n' |
    qs-render model.qs --path - --resolution 64,48 -o 'frame-%d.png'
