# A mesh that ends too early is refused, wherever it ends.
whole=$QS_DATA/mesh-little-endian.ply
size=$(stat -c %s "$whole")
for ((length = 0; length < size; ++length)); do
    head -c "$length" "$whole" > cut.ply
    "$QS_SOURCE/tests/tools/expect-refusal" qs-build cut.ply -o model.qs || echo "cut off at byte $length"
done
qs-build "$whole" -o model.qs && ls
