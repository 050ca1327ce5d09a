# The sphere of a model's root is a little larger than that of its mesh; two digits are the same.
round() { perl -pe 's/-?\d+(\.\d+)?(e[-+]?\d+)?/abs($&) < 5e-3 ? 0 : 0 + sprintf("%.2f", $&)/ge'; }
printf "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n10 0 0\n14 0 0\n10 4 0\n14 4 4\n3 0 1 2\n3 1 3 2\n3 0 2 3\n3 0 3 1\n" > tetrahedron.ply
qs-build --quiet tetrahedron.ply -o tetrahedron.qs
for scene in tetrahedron.ply tetrahedron.qs; do
    qs-path orbit $scene --frames 1 --elevation 0 | round
done
