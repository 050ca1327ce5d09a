# Triangles as leaves: the file that qs(5) shows, and the mesh comes back from the last level.
qs-build "$QS_DATA/tiny.ply" --leaf triangle -o tiny.qs --report report.json
cmp tiny.qs "$QS_DATA/tiny-triangles.qs"
qs-info --verify tiny.qs
grep -oE '"(leaf|triangles_[a-z_]+|vertices_merged|lattice_bits|leaves)":[^,]*' report.json

"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
qs-build --quiet mesh.ply --leaf triangle -o model.qs
qs-build --quiet --threads 1 mesh.ply --leaf triangle -o one.qs
cmp model.qs one.qs
levels=$(qs-info --json model.qs | grep -o '"level_count":[0-9]*' | cut -d: -f2)
qs-info --cut "$levels" model.qs -o leaves.ply --report - | grep -o '"triangles":.*'
grep -a -E '^element (vertex|face)' mesh.ply leaves.ply
qs-info --cut $((levels - 1)) model.qs -o points.ply --report - | grep -o '"points":'
qs-build --quiet leaves.ply -o again.qs && qs-info --verify again.qs | grep -o whole
