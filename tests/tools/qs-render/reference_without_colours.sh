qs-build "$QS_DATA/mesh-normals-colours.ply" -o model.qs
cp "$QS_DATA/mesh-ascii.ply" grey.ply
qs-render model.qs --resolution 64,48 --reference grey.ply --report report.jsonl
wc -l < report.jsonl
