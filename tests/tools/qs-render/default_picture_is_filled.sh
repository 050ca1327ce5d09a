# Without a path the model fills the picture, from whatever side and of whatever shape: it touches no border, but two
# that face each other are near, and about as near.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > round.ply
# The same, six times as wide.
awk 'NF == 3 && $1 ~ /^-?[0-9.]+$/ { $1 *= 6 } { print }' round.ply > wide.ply

# Prints "filled", or the part of the picture that the model takes.
filled() { # PICTURE WIDTH HEIGHT
    tail -c $((3 * $2 * $3)) "$1" | od -An -v -tu1 -w$((3 * $2)) | awk -v width="$2" -v height="$3" '
        BEGIN { left = width; top = height; right = bottom = -1 }
        { for (x = 0; x < width; ++x) if ($(3 * x + 1) > 0) {
              if (x < left) left = x; if (x > right) right = x; if (NR - 1 < top) top = NR - 1; bottom = NR - 1 } }
        function part(first, last, whole) { return (last - first + 1) / whole }
        function balanced(first, last, whole) { d = first - (whole - 1 - last); return d < 0.12 * whole && d > -0.12 * whole }
        END {
            wide = part(left, right, width); high = part(top, bottom, height)
            if (wide < 1 && high < 1 && (wide > 0.75 && balanced(left, right, width) || high > 0.75 && balanced(top, bottom, height)))
                print "filled"
            else printf "%d..%d x %d..%d of %d x %d\n", left, right, top, bottom, width, height
        }'
}

for name in round wide; do
    qs-build $name.ply -o $name.qs
    qs-render $name.qs --resolution 320,240 -o a.ppm && filled a.ppm 320 240
    qs-render $name.qs --resolution 120,360 -o a.ppm && filled a.ppm 120 360
    qs-render $name.qs --resolution 320,240 --camera-azimuth-angle 40 --camera-elevation-angle -20 \
        --camera-view-angle 80 --camera-view-up 0,0,1 -o a.ppm && filled a.ppm 320 240
done

# Where the focal point is given it is in the middle, and the model as far off as in an orbit.
qs-path orbit round.qs --frames 1 --resolution 320,240 -o path.jsonl
qs-render round.qs --resolution 320,240 --path path.jsonl -o orbit.ppm
centre=$(grep -oE '"target":\[[^]]*' path.jsonl | cut -d[ -f2)
qs-render round.qs --resolution 320,240 --camera-focal-point "$centre" -o focused.ppm
cmp orbit.ppm focused.ppm && echo "as in an orbit"
