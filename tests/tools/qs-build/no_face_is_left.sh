printf 'ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n3 0 1 1\n' > mesh.ply
qs-build mesh.ply -o mesh.qs
qs-info mesh.qs | grep -e surface -e leaves
