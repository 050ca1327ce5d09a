# What a frame needs, in words and as JSON; no picture is drawn.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
qs-build --quiet mesh.ply -o model.qs
qs-build --quiet --no-colour mesh.ply -o grey.qs
explain() { qs-render --explain --backend cpu "$@"; }
explain model.qs | sed -E 's/[0-9.]+/N/g'
echo
explain grey.qs --shade flat --splat circle --keep-backfaces | grep 'leaves out'
echo
echo '{"eye":[0,0,4],"target":[0,0,0],"near":3.5}' | explain model.qs --path - | grep -E 'near'
echo
explain model.qs --json | grep -oE '"[a-z_]+":' | sort -u | tr -d '\n'
echo
head -c 4K model.qs | explain - 2> /dev/null | grep -E '^model|missing'
explain model.qs > one
explain model.qs --threads 1 | cmp - one
for option in "-o x.png" "--depth x.pfm" "--report x" "--budget 33" --refine "--reference mesh.ply"; do
    # shellcheck disable=SC2086
    explain model.qs $option 2>&1 | head -n 1
done
qs-render model.qs -o x.png --json 2>&1 | head -n 1
ls
