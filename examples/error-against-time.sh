#!/bin/bash
# What a smaller error costs: draws the same path at falling thresholds and prints, for each, the median
# over the frames.  With a reference mesh the table has the measured error too.
#     examples/error-against-time.sh scan.qs [scan.ply [FRAMES]]
set -euo pipefail
[ $# -ge 1 ] && [ $# -le 3 ] || { echo "usage: error-against-time.sh MODEL [REFERENCE [FRAMES]]" >&2; exit 2; }
model=$1
reference=(${2:+--reference "$2"})
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

qs-path dolly "$model" --frames "${3:-24}" >"$work/dolly.jsonl"
for threshold in 8 4 2 1 0.5; do
    qs-render "$model" --path "$work/dolly.jsonl" --threshold $threshold "${reference[@]}" \
        --format rgb -o - --report "$work/$threshold.jsonl" >/dev/null
done
python3 - "$work" <<'PYTHON'
import json, statistics, sys
keys = ["splats", "error_bound_px", "psnr_db", "holes"]
print(f"{'threshold_px':>12} {'ms':>8}", *(f"{key:>14}" for key in keys))
for threshold in ["8", "4", "2", "1", "0.5"]:
    frames = [json.loads(line) for line in open(f"{sys.argv[1]}/{threshold}.jsonl")]
    median = lambda values: statistics.median(values) if values else float("nan")
    print(f"{threshold:>12} {median([frame['ms']['total'] for frame in frames]):8.2f}",
          *(f"{median([frame[key] for frame in frames if frame.get(key) is not None]):14.2f}" for key in keys))
PYTHON
