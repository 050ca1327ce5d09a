# The first blocks of a model are a coarser model, from a pipe too, and the report says so.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
qs-build mesh.ply -o model.qs
head -c 3K model.qs | qs-render - --resolution 320,240 -o coarse.png --report report.jsonl 2> said
sed -E 's/of [0-9]+ blocks/of N blocks/' said
grep -o '"model_blocks_present":[0-9]*' report.jsonl
grep -c '"groups_missing":[1-9]' report.jsonl
qs-render model.qs --resolution 320,240 --report report.jsonl
grep -o '"groups_missing":[0-9]*' report.jsonl
