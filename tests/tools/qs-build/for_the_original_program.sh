cp "$QS_DATA/mesh-normals-colours.ply" mesh.ply
qs-build mesh.ply --format qsplat11 -o old.qs --report report.json
python3 -c 'import json; r = json.load(open("report.json")); print(r["vertices_in"], r["leaves"], r["levels"], r["file_bytes"])'
qs-info old.qs
qs-build mesh.ply --format qsplat11 --no-colour -o grey.qs
qs-info --json grey.qs | grep -o '"has_colour":[a-z]*' | head -n 1
qs-render old.qs --resolution 64,48 -o frame.png && ls frame.png
for threads in 1 2 16; do qs-build mesh.ply --format qsplat11 --threads $threads -o "$threads.qs"; cmp old.qs $threads.qs; done
qs-build mesh.ply --format qsplat11 --memory 1G -o no.qs || echo "status $?"
qs-build mesh.ply --format qsplat12 -o no.qs || echo "status $?"
printf 'ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n1 1 1\n' > two.ply
qs-build two.ply --format qsplat11 -o no.qs || echo "status $?"
[[ ! -e no.qs ]]
