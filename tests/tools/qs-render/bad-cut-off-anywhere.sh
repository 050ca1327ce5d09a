# A model that ends too early: refused where not one block is whole, else drawn as far as it goes.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > mesh.ply
qs-build mesh.ply -o whole.qs
size=$(stat -c %s whole.qs)
first=$((1024 + 1024))
for length in $(seq 0 256) $((first - 1)) "$first" $(seq 257 61 $((size - 1))); do
    head -c "$length" whole.qs > cut.qs
    if ((length < first)); then
        "$QS_SOURCE/tests/tools/expect-refusal" qs-render cut.qs -o frame.ppm --resolution 64,48 ||
            echo "cut off at byte $length"
    else
        got=$(timeout 20 qs-render cut.qs -o frame.ppm --resolution 64,48 2>&1)
        [[ $? == 0 && $got == "qs-render: warning: cut.qs: "* && $got != *$'\n'* && -s frame.ppm ]] ||
            echo "cut off at byte $length: $got"
        rm -f frame.ppm
    fi
done
ls
