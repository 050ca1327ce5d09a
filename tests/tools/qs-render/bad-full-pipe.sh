# A full disk behind standard output, for each thing that can go there.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
for what in "-o -" "--depth -" "--report - -o frame.ppm"; do
    qs-render model.qs --resolution 640,480 $what > /dev/full
    echo "exit $?"
done
