#!/bin/bash
# One mesh, all that can be made of it, the same pictures: what each way costs in bytes and milliseconds, and how far its
# pictures are from those of the mesh itself.
#     examples/compare-representations.sh SCAN [FRAMES]
#
# splats: a model of splats; triangles: with the mesh's triangles as leaves, those of 4 pixels and more drawn as what they
# are; triangles_2px: the same model, with those of 2 pixels and more; compressed: splats, to be sent whole; progressive: a
# progressive mesh, refined for each view; points: of a sampling server, which sends what the view lacks.
# Of a small scan in a small picture hardly a triangle has 4 pixels.  What is drawn then are splats in both models, and
# those of triangles are the coarser ones: they have a triangle's normal, those of vertices the mean of the faces about it.
# Bytes are of the file; of points, what the server sent for the path. PSNR and milliseconds are medians over the frames.
set -euo pipefail
[ $# -ge 1 ] && [ $# -le 2 ] || { echo "usage: compare-representations.sh SCAN [FRAMES]" >&2; exit 2; }
scan=$(realpath -e "$1") frames=${2:-12}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

qs-path orbit "$scan" --frames "$frames" -o orbit.jsonl
qs-build --quiet "$scan" -o splats.qs
qs-build --quiet "$scan" --leaf triangle -o triangles.qs
qs-build --quiet "$scan" --compress -o compressed.qs
pm-build --quiet "$scan" -o progressive.pm

draw() { # NAME SOURCE...
    qs-render --quiet "${@:2}" --path orbit.jsonl --resolution 640,360 --reference "$scan" --format rgb -o - \
        --report "$1.jsonl" >/dev/null
}
for model in *.qs *.pm; do draw "${model%.*}" "$model"; done
draw triangles_2px triangles.qs --triangle-size 2
draw points --ppve-command "ppve-sample '$scan'"

python3 - <<'PYTHON'
import json, os, statistics
print(f"{'':13} {'bytes':>12} {'psnr_db':>8} {'ms':>8}")
for name in ["splats", "triangles", "triangles_2px", "compressed", "progressive", "points"]:
    frames = [json.loads(line) for line in open(name + ".jsonl")]
    model = name.split("_")[0]
    files = [file for file in (model + ".qs", model + ".pm") if os.path.exists(file)]
    size = os.path.getsize(files[0]) if files else sum(frame["bytes_received"] for frame in frames)
    psnr = statistics.median(frame["psnr_db"] for frame in frames)
    ms = statistics.median(frame["ms"]["total"] for frame in frames)
    print(f"{name:13} {size:12} {psnr:8.2f} {ms:8.2f}")
PYTHON
