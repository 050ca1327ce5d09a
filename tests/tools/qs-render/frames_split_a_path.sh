# A path drawn in parts is the path drawn in one: files, numbers and report.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
qs-path orbit model.qs --frames 7 -o path.jsonl
mkdir whole parts
draw="qs-render model.qs --path path.jsonl --resolution 40,30"
$draw -o whole/%02d.png --depth whole/%02d.pfm --report whole.jsonl
for range in :3 3:4 4:; do
    $draw -o parts/%02d.png --depth parts/%02d.pfm --frames $range --report part.jsonl
    cat part.jsonl >> parts.jsonl
done
diff -r whole parts && echo same
for report in whole parts; do
    grep -o '"frame":[0-9]*' $report.jsonl | tr '\n' ' '
    echo
done
$draw --frames 1:6:2 -o step-%d.ppm && ls step-*
# Beyond the end is the end; a range that has no frame is refused.
$draw --frames 5:100 -o end-%d.ppm && ls end-*
$draw --frames 7: -o none-%d.ppm 2>&1
# A file takes one frame of many.
$draw --frames 2:3 -o one.png && ls one.png
# Every second frame is shown for twice as long.
$draw --frames ::2 -o - | head -n 1
