# The fourth vertex belongs to no triangle, so it is not looked at.
# Digits beyond the fourth depend on the system's sine.
round() { perl -pe 's/-?\d+(\.\d+)?(e[-+]?\d+)?/abs($&) < 5e-5 ? 0 : 0 + sprintf("%.4f", $&)/ge'; }
printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n10 0 0\n12 0 0\n10 2 0\n500 500 500\n3 0 1 2\n' > triangle.ply
qs-path orbit triangle.ply --frames 1 --elevation 0 | round
