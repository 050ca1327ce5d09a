# A reader that has seen enough ends the program quietly.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
qs-path orbit model.qs --frames 50 | qs-render model.qs --path - -o - --resolution 640,480 | head -c 10
echo " ${PIPESTATUS[*]}"

# What else is written is written whole.
draw() { qs-render model.qs --path path.jsonl --resolution 64,48 "$@"; }
qs-path orbit model.qs --frames 2000 -o path.jsonl
draw -o whole.y4m --report - | head -n 1 | wc -l
echo "${PIPESTATUS[*]} $(grep -ac FRAME whole.y4m)"
draw -o - --report report.jsonl | head -c 10
echo " ${PIPESTATUS[*]} $(grep -c . report.jsonl)"
draw -o "%d.ppm" --report - | head -n 1 | wc -l
echo "${PIPESTATUS[*]} $(ls ./*.ppm | wc -l)"
rm ./*.ppm
head -n 1 path.jsonl > still.jsonl
qs-render model.qs --path still.jsonl --frames 0:1 --depth - -o "%d.ppm" --resolution 2000,2000 | head -c 2
echo " ${PIPESTATUS[*]} $(ls ./*.ppm | wc -l)"
