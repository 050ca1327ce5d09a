#!/bin/bash
# Splits a long path among worker processes and joins what they draw; with ssh in place of bash the same
# lines serve a row of machines.  The frames are those that one process would have drawn.
#     examples/farm.sh scan.qs path.jsonl video.mp4 [WORKERS]
set -euo pipefail
[ $# -ge 3 ] && [ $# -le 4 ] || { echo "usage: farm.sh MODEL PATH VIDEO [WORKERS]" >&2; exit 2; }
model=$1 path=$2 video=$3 workers=${4:-$(nproc)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

split --number=l/"$workers" --numeric-suffixes --elide-empty-files "$path" "$work/part-"
printf '%s\n' "$work"/part-* |
    xargs -P "$workers" -I{} qs-render "$model" --path {} --threads 1 --format ppm -o {}.frames
cat "$work"/part-*.frames | ffmpeg -loglevel error -y -f image2pipe -framerate 24 -i - -pix_fmt yuv420p \
    -colorspace smpte170m "$video"
