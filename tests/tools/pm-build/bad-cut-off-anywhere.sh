# A model that ends too early is refused, wherever it ends; so is one with a byte too many.
pm-build "$QS_DATA/tiny.ply" -o whole.pm
size=$(stat -c %s whole.pm)
for ((length = 0; length < size; length += 31)); do
    head -c "$length" whole.pm > cut.pm
    "$QS_SOURCE/tests/tools/expect-refusal" qs-info --verify cut.pm || echo "cut off at byte $length"
    "$QS_SOURCE/tests/tools/expect-refusal" pm-build cut.pm --level full -o out.ply || echo "cut off at byte $length"
done
(cat whole.pm; printf x) | qs-info -
echo "exit $?"
