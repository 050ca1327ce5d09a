# Models side by side, moved by numbers and by a file; the report has the sums.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 40 > mesh.ply
qs-build mesh.ply -o model.qs
cp model.qs other.qs
splats() {
    qs-render "$@" --resolution 320,240 --camera-position 0,0,9 --camera-focal-point 0,0,0 --occlusion off -o frame.png \
        --report - | grep -oE '"(splats|model_blocks|model_blocks_present)":[0-9]+' | cut -d: -f2 | tr '\n' ' '
}
read -r one blocks _ <<< "$(splats model.qs)"
read -r two blocks_of_two present <<< "$(splats model.qs other.qs)"
((two == 2 * one)) && ((blocks_of_two == 2 * blocks)) && ((present == 2 * blocks)) && echo "two models, sums of both"

# A matrix in a file and the same in numbers are the same bytes.
printf '0 0 2 0.5\n0 2 0 0\n-2 0 0 0\n0 0 0 1\n' > turn.xf
view="--resolution 320,240 --camera-position 0,0,9 --camera-focal-point 0,0,0"
qs-render model.qs other.qs@turn.xf $view -o file.ppm
qs-render model.qs "other.qs@0,0,2,0.5,0,2,0,0,-2,0,0,0,0,0,0,1" $view -o numbers.ppm
cmp file.ppm numbers.ppm && echo "a matrix is a matrix"

# Only the place where a model stands counts, not by which name or how often it is read.
qs-render model.qs model.qs@1.5,0,0 $view -o twice.ppm
qs-render model.qs other.qs@1.5,0,0 $view -o copies.ppm
cmp twice.ppm copies.ppm && echo "one file, two places"
cmp -s twice.ppm file.ppm || echo "elsewhere it looks different"

# The default camera has both of them in the picture: nothing touches its border.
qs-render model.qs model.qs@30,0,0 --resolution 320,240 -o far.ppm
tail -c $((3 * 320 * 240)) far.ppm | od -An -v -tu1 -w960 |
    awk '{ if (NR == 1 || NR == 240) for (i = 1; i <= NF; ++i) border += $i; border += $1 + $960 } END { print "border " border }'

# What looks like a transform but is none belongs to the name.
cp model.qs 'odd@name.qs'
qs-render odd@name.qs $view -o odd.ppm && qs-render 'odd@name.qs@0,0,0' $view -o same.ppm && cmp odd.ppm same.ppm &&
    echo "a name with an at sign"
qs-render - model.qs@1.5,0,0 $view -o piped.ppm < model.qs && cmp piped.ppm twice.ppm && echo "one of them from a pipe"

# Moved far away, where numbers are coarse, it is still framed as it was.
covered() { qs-render "$1" --resolution 320,240 --shade flat --format rgb -o - | od -An -v -tu1 -w3 | grep -vc '^   0   0   0$'; }
near=$(covered model.qs)
for x in 1e6 1e12 1e13 1e14; do
    far=$(covered "model.qs@$x,0,0")
    ((far > near * 98 / 100 && far < near * 102 / 100)) && echo "framed at $x" || echo "$far pixels at $x, not $near"
done
