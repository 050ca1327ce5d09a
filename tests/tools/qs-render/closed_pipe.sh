# A reader that has seen enough ends the program quietly.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
qs-path orbit model.qs --frames 50 | qs-render model.qs --path - -o - --resolution 640,480 | head -c 10
echo " ${PIPESTATUS[*]}"
