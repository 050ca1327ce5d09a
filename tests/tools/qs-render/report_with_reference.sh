# The measures of each frame, and the bound above them; no picture is needed.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 40 > mesh.ply
qs-build mesh.ply -o model.qs
qs-path orbit model.qs --frames 3 -o path.jsonl
for threshold in 0 1 4; do
    qs-render model.qs --path path.jsonl --resolution 320,240 --quiet --threshold "$threshold" --reference mesh.ply --report - |
        tee report.jsonl | grep -c '"holes":0,'
    paste <(grep -o '"error_bound_px":[0-9.e-]*' report.jsonl) <(grep -o '"measured_error_px":[0-9.e-]*' report.jsonl) |
        awk -F'[:\t]' '$2 >= $4 && $4 > 0 { ++kept } END { print kept " within the bound" }'
done
head -n 1 report.jsonl | grep -oE '"[a-z_]+":' | tr -d '\n'
echo
ls -A
