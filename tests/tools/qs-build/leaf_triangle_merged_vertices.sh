# Corners that the lattice cannot tell apart are counted, and their triangles are kept.
cat > mesh.off << 'MESH'
OFF
6 2 0
0 0 0
1 0 0
0 1 0
0.5 0.5 0
0.50000000001 0.5 0
0.5 0.50000000001 0
3 0 1 2
3 3 4 5
MESH
qs-build mesh.off --leaf triangle -o model.qs
qs-info --verify model.qs
