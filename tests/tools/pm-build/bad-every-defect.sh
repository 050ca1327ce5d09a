# Every file with a defect is refused in one line, and leaves nothing behind.
cp "$QS_DATA"/bad/mesh-* .
for file in mesh-*; do
    "$QS_SOURCE/tests/tools/expect-refusal" pm-build "$file" -o model.pm
done
