# A flipped bit: in the header and the zeros behind it always refused, in the body refused or not met; found by qs-info wherever it is.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > mesh.ply
qs-build mesh.ply -o model.qs
size=$(stat -c %s model.qs)

flip() { # BIT
    local at=$(($1 / 8)) byte
    byte=$(od -An -tu1 -j "$at" -N 1 model.qs)
    cp model.qs flipped.qs
    printf "\\x$(printf %02x $((byte ^ 1 << $1 % 8)))" |
        dd of=flipped.qs bs=1 seek="$at" conv=notrunc status=none
}

# 5 and 509 are prime to the period of the format's fields.
for ((bit = 0; bit < 8 * 1024; bit += bit < 8 * 256 ? 5 : 509)); do
    flip "$bit"
    "$QS_SOURCE/tests/tools/expect-refusal" qs-render flipped.qs -o frame.ppm --resolution 64,48 ||
        echo "bit $bit"
done
for ((bit = 8 * 1024; bit < 8 * size; bit += 509)); do
    flip "$bit"
    got=$(timeout 20 qs-render flipped.qs -o frame.ppm --resolution 64,48 --threshold 0 2>&1)
    status=$?
    ((status <= 1)) && [[ $got != *$'\n'* ]] || echo "bit $bit: exit $status: $got"
    [[ $status == 0 || $got == "qs-render: flipped.qs: block "* ]] || echo "bit $bit: exit $status: $got"
    qs-info --verify flipped.qs > /dev/null 2> message
    status=$?
    [[ $status == 1 && $(< message) == "qs-info: flipped.qs: block "* ]] ||
        echo "bit $bit: qs-info: exit $status: $(< message)"
done
