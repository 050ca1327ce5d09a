# A budget changes thresholds, never below --threshold, and nothing else of a picture.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
qs-build --quiet mesh.ply -o model.qs
qs-path orbit model.qs --frames 5 -o path.jsonl
draw() { qs-render model.qs --path path.jsonl --resolution 320,240 "$@"; }

# More time than any frame needs: the pictures of --threshold.
draw --quiet --threshold 2 -o "plain-%d.ppm"
draw --quiet --threshold 2 --budget 60s -o "rich-%d.ppm" --report rich.jsonl
draw --quiet --threshold 2 --budget 1m --splat ellipse -o "ellipse-%d.ppm"
for i in 0 1 2 3 4; do cmp "plain-$i.ppm" "rich-$i.ppm"; done
grep -c '"threshold_px":2.0,.*' rich.jsonl
head -n 1 rich.jsonl | grep -oE '"[a-z_]+":' | tr -d '\n'
echo

# Less than a frame can take: complete pictures all the same, and the report says that they were late.
draw --budget 0.001ms --reference mesh.ply --report poor.jsonl 2>&1 | sed 's/took [0-9.e+]* ms/took T ms/'
grep -c '"holes":0,' poor.jsonl
grep -o '"overshoot":[0-9.]*' poor.jsonl | awk -F: '$2 > 1 { ++late } END { print late " late" }'
grep -o '"threshold_px":[0-9.]*' poor.jsonl | awk -F: '$2 > 1 { ++coarse } END { print coarse " coarser than 1 px" }'
grep -o '"predicted_ms":[0-9.]*' poor.jsonl | awk -F: '$2 > 0.001 { ++late } END { print late " expected to be late" }'
draw --budget 0.001ms --quiet --threshold-diameter 4 --report poor.jsonl
draw --budget 1m --verbose --threshold-diameter 4 --report rich.jsonl 2>&1 | grep budget
grep -o '"threshold_diameter_px":[0-9.]*' poor.jsonl | awk -F: '$2 >= 4 { ++coarse } END { print coarse " coarser" }'
