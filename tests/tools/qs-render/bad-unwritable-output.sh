# Places where no picture can be, for root either.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
: > file
for output in file/frame.ppm no/such/folder/frame.ppm file/frame-%04d.png; do
    qs-render model.qs --resolution 64,48 -o "$output"
    echo "exit $?"
done
qs-render model.qs --resolution 64,48 --depth file/depth.pfm
echo "exit $?"
qs-render model.qs --resolution 64,48 --report file/report.jsonl
echo "exit $?"
ls -A
