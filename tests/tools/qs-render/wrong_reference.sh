# Of a mesh that the model was not made of, a warning says so; of its own there is none, nor where no bound is
# given.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
"$QS_SOURCE/tests/tools/make-bumpy-ply" 5 > other.ply
qs-build mesh.ply -o model.qs
draw() { qs-render model.qs --resolution 320,240 --report report.jsonl "$@"; }
for reference in mesh.ply other.ply; do
    draw --reference $reference
    draw --reference $reference --splat square
    draw --reference $reference --camera-view-angle 0.01
    draw --reference $reference --quiet
done
