# Inputs are never written over, whatever they are called.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
qs-path orbit model.qs --frames 1 -o path.jsonl
cp model.qs copy.qs
cp path.jsonl copy.jsonl
ln -s model.qs link.ppm
qs-render model.qs --resolution 64,48 --format ppm -o model.qs
echo "exit $?"
qs-render model.qs --resolution 64,48 -o link.ppm
echo "exit $?"
qs-render model.qs --resolution 64,48 --depth ./model.qs
echo "exit $?"
qs-render model.qs --resolution 64,48 --path path.jsonl --format ppm -o path.jsonl
echo "exit $?"
cmp model.qs copy.qs
cmp path.jsonl copy.jsonl
ls -A
