# Two eyes: side by side they are what the two files hold.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
draw="qs-render model.qs --resolution 40,30 --stereo --eye-angle 10"
$draw -o both.ppm --depth both.pfm
$draw -o %s.ppm --depth %s.pfm --report report.jsonl
grep -o '"eye":"[a-z]*"' report.jsonl
head -n 2 both.ppm | tail -n 1
rows() { # FILE BYTES_A_ROW
    tail -c $((30 * $2)) "$1" | od -An -v -tx1 -w"$2"
}
cmp <(rows both.ppm 240) <(paste -d '' <(rows left.ppm 120) <(rows right.ppm 120)) && echo "pictures side by side"
cmp <(rows both.pfm 320) <(paste -d '' <(rows left.pfm 160) <(rows right.pfm 160)) && echo "depths side by side"
cmp -s left.ppm right.ppm || echo "the eyes see different pictures"
# A stream for each eye.
qs-path orbit model.qs --frames 3 | qs-render model.qs --path - --resolution 16,16 --stereo -o %s.y4m
for eye in left right; do grep -a -c FRAME $eye.y4m; done
