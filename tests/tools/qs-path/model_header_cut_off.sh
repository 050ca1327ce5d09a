printf "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n10 0 0\n14 0 0\n10 4 0\n14 4 4\n3 0 1 2\n3 1 3 2\n3 0 2 3\n3 0 3 1\n" > tetrahedron.ply
qs-build --quiet tetrahedron.ply -o tetrahedron.qs
head -c 255 tetrahedron.qs > cut.qs
qs-path orbit cut.qs
