#!/bin/bash
# A video of a model that turns, and the same again shaded by how coarse each splat is.
#     examples/turntable.sh scan.qs turntable
set -euo pipefail
[ $# -eq 2 ] || { echo "usage: turntable.sh MODEL NAME" >&2; exit 2; }
model=$1 name=$2

qs-path orbit "$model" --frames 180 --elevation 20 >"$name.jsonl"
for shade in lit level; do
    qs-render "$model" --path "$name.jsonl" --shade $shade -o - |
        ffmpeg -loglevel error -y -i - -pix_fmt yuv420p -colorspace smpte170m "$name-$shade.mp4"
done
