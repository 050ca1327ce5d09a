printf 'ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n' > empty.ply
qs-build empty.ply -o empty.qs
