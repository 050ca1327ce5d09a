# Each camera is drawn finer and finer; the last picture is that of --threshold, and is the only one that is written.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
qs-build --quiet mesh.ply -o model.qs
qs-path orbit model.qs --frames 2 -o path.jsonl
draw() { qs-render model.qs --path path.jsonl --resolution 320,240 --quiet "$@"; }
draw --threshold 2 -o "plain-%d.ppm"
draw --threshold 2 --refine -o "refined-%d.ppm" --report report.jsonl
for i in 0 1; do cmp "plain-$i.ppm" "refined-$i.ppm"; done
sed -E 's/.*"frame":([0-9]*),.*"refinement":([0-9]*),.*"threshold_px":([0-9]*.?[0-9]?).*/\1 \2 \3/' report.jsonl
grep -o '"elapsed_ms":[0-9.]*' report.jsonl | head -n 9 | sort -c -t: -k2 -g && echo "time passes"

# The curve of error against time.
draw --threshold 0 --refine --reference mesh.ply --report report.jsonl
grep -o '"frame":0.*"psnr_db":[0-9.]*' report.jsonl | sed 's/.*://' | awk '
    NR == 1 { first = $1 } { last = $1 } END { print (last > first + 6) ? "finer" : first " to " last " dB" }'
tail -n 1 report.jsonl | grep -c '"threshold_px":0.0,' # the leaves were reached before

# What a budget allows comes first.
draw --threshold 2 --refine --budget 1s --report report.jsonl
grep -c '"refinement":0,.*"threshold_px":2.0,' report.jsonl
grep -c '"refinement":1,' report.jsonl
# A stream has a picture for each camera.
draw --refine -o - | head -n 1 | cut -d' ' -f1
draw --refine --format rgb -o - | wc -c
