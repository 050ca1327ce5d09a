awk "BEGIN { n = 24; print \"ply\nformat ascii 1.0\nelement vertex \" n * n \"\nproperty float x\nproperty float y\nproperty float z\nelement face \" 2 * (n - 1) * (n - 1) \"\nproperty list uchar int vertex_indices\nend_header\"; for (r = 0; r < n; ++r) for (c = 0; c < n; ++c) print r, c, (r * c) % 5; for (r = 0; r < n - 1; ++r) for (c = 0; c < n - 1; ++c) { a = r * n + c; print 3, a, a + n, a + n + 1; print 3, a, a + n + 1, a + 1 } }" > grid.ply
qs-build grid.ply -o grid.qs
head -c 3500 grid.qs > cut.qs
qs-info --verify cut.qs
