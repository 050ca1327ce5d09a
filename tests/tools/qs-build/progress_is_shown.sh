cp "$QS_DATA/tiny.ply" .
qs-build tiny.ply -o tiny.qs --progress always 2>&1 | tr '\r' '\n' | grep -c '^qs-build: leaves [0-9]*%' | sed 's/^[1-9][0-9]*$/shown/'
qs-build tiny.ply -o tiny.qs --progress never 2>&1 | grep -c leaves
ls
