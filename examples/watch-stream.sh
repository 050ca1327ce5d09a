#!/bin/bash
# How the picture of a model at a web server fills in: a contact sheet of what could be drawn after each time.
#     examples/watch-stream.sh URL SHEET.png [RATE [SECOND...]]
#
# RATE is the link to be tried, in bits a second as in 384k or 8M (default: 2M); the times are seconds since the start
# (default: 0.1 0.25 0.5 1 2 4), read from left to right and down. The cache begins empty and is thrown away.
set -euo pipefail
[ $# -ge 2 ] || { echo "usage: watch-stream.sh URL SHEET.png [RATE [SECOND...]]" >&2; exit 2; }
url=$1 sheet=$2 rate=${3:-2M}
times=("${@:4}")
[ ${#times[@]} -gt 0 ] || times=(0.1 0.25 0.5 1 2 4)
work=$(mktemp -d)
trap 'kill %1 2>/dev/null; wait; rm -rf "$work"' EXIT

mkdir -m 700 "$work/cache"
qs-fetch serve --cache "$work/cache" --limit-rate "$rate" &
until [ -S "$work/cache/socket" ]; do sleep 0.02; done
snapshots=$(printf '%ss,' "${times[@]}")
qs-render --quiet "$url" --cache "$work/cache" --snapshot "${snapshots%,}" --resolution 480,360 -o "$work/at-%02d.png"
columns=$(((${#times[@]} + 1) / 2))
ffmpeg -loglevel error -y -i "$work/at-%02d.png" -frames:v 1 -vf "tile=${columns}x2:padding=4:color=gray" "$sheet"
