# The input by other names is still the input: it stays as it is.
cp "$QS_DATA/mesh-ascii.ply" mesh.ply
ln -s mesh.ply symbolic.ply
ln mesh.ply hard.ply
for output in mesh.ply ./mesh.ply symbolic.ply hard.ply; do
    qs-build mesh.ply -o "$output"
    echo "exit $?"
done
cmp mesh.ply "$QS_DATA/mesh-ascii.ply" && ls -A
