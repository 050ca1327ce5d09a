qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
echo '{"eye":[2,3,9],"target":[0,0,0],"near":0.5,"far":2}' > path.jsonl
qs-render model.qs --resolution 64,48 --path path.jsonl -o a.ppm
sed 's/,"near.*/}/' path.jsonl > without.jsonl
qs-render model.qs --resolution 64,48 --path without.jsonl -o b.ppm
cmp a.ppm b.ppm
