#!/bin/bash
# Makes the small inputs that the examples of man pages name, in the working folder.
#
#     examples-setup.sh WORD...
#
# The words are all those of the examples.  One that names a kind of file known below becomes such a
# file; every other is passed over.  A new kind is a new pattern.  Outputs of examples match as well,
# and are replaced when their example runs.
set -eu

# A closed, bumpy, coloured ball of 2520 faces, with normals: more than one block of a model.
make_mesh() {
    awk 'BEGIN {
        pi = 3.14159265358979; n = 36; rings = 36
        printf "ply\nformat ascii 1.0\nelement vertex %d\n", 2 + n * (rings - 1)
        split("x y z nx ny nz", names, " ")
        for (i = 1; i <= 6; ++i) print "property float " names[i]
        print "property uchar red\nproperty uchar green\nproperty uchar blue"
        printf "element face %d\nproperty list uchar int vertex_indices\nend_header\n", 2 * n * (rings - 1)
        print "0 1 0 0 1 0 200 80 40"
        for (r = 1; r < rings; ++r) for (i = 0; i < n; ++i) {
            a = pi * r / rings; b = 2 * pi * i / n; s = 1 + 0.1 * sin(5 * b) * sin(a) * sin(4 * a)
            x = sin(a) * cos(b); y = cos(a); z = sin(a) * sin(b)
            printf "%.5f %.5f %.5f %.5f %.5f %.5f %d %d %d\n", s * x, s * y, s * z, x, y, z,
                128 + 100 * x, 128 + 100 * y, 128 + 100 * z
        }
        print "0 -1 0 0 -1 0 40 80 200"
        last = 1 + n * (rings - 1)
        for (i = 0; i < n; ++i) {
            j = (i + 1) % n
            print 3, 0, 1 + j, 1 + i
            for (r = 0; r < rings - 2; ++r) {
                p = 1 + r * n
                print 3, p + i, p + j, p + n + i
                print 3, p + j, p + n + j, p + n + i
            }
            print 3, last, last - n + i, last - n + j
        }
    }'
}

[[ -e mesh.tmp ]] || make_mesh > mesh.tmp
for name; do
    case $name in
        *%* | */* | -*) continue ;;
    esac
    [[ -e $name ]] && continue
    case $name in
        *.ply) cp mesh.tmp "$name" ;;
        *.qs) qs-build - -o "$name" < mesh.tmp ;;
        *.pm) pm-build - -o "$name" < mesh.tmp ;;
        *.jsonl) qs-path orbit - --frames 4 -o "$name" < mesh.tmp ;;
        *.png | *.ppm) ffmpeg -v error -f lavfi -i testsrc2=size=160x120 -frames:v 1 -f image2 "$name" ;;
        frames-[a-z]) mkdir "$name" && ffmpeg -v error -f lavfi -i testsrc2=size=160x120 -frames:v 3 "$name/%04d.png" ;;
        *.y4m) ffmpeg -v error -f lavfi -i testsrc2=size=160x120 -frames:v 4 "$name" ;;
    esac
done
rm -f mesh.tmp
