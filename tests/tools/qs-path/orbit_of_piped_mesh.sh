printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n10 0 0\n12 0 0\n10 2 0\n500 500 500\n3 0 1 2\n' > triangle.ply
qs-path orbit triangle.ply > named.jsonl
cat triangle.ply | qs-path orbit - | cmp - named.jsonl
