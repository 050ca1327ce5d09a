#!/bin/bash
# Builds a model of every scan in a folder that has none yet, or an older one: a job for cron, as often as wanted.
#     examples/batch.sh SCANS MODELS [OPTION OF QS-BUILD...]
#
# MODELS/NAME.qs comes of SCANS/NAME.ply (or .obj, .off, .stl, .drc). What is done is skipped; a run that was killed leaves
# no half model, and the next run goes on where it was. A second run at the same time ends at once. Says nothing unless
# something fails, so that cron mails nothing else; a scan that fails is named, the others are built, and the exit
# status is 1.
#     */10 * * * *  batch.sh /srv/scans /srv/www/models --compress
set -euo pipefail
[ $# -ge 2 ] || { echo "usage: batch.sh SCANS MODELS [OPTION OF QS-BUILD...]" >&2; exit 2; }
scans=$1 models=$2
shift 2
mkdir -p "$models"
exec 9>"$models/.batch.lock"
flock --nonblock 9 || exit 0
rm -f "$models"/.qs-*.tmp # what a run that was killed outright had begun: nobody else writes here

failed=0
shopt -s nullglob nocaseglob
for scan in "$scans"/*.{ply,obj,off,stl,drc}; do
    name=$(basename "$scan")
    model=$models/${name%.*}.qs
    # Newer scans are built again. A scan that is still being copied changes once more, and is built again then.
    [ "$model" -nt "$scan" ] || qs-build --quiet "$scan" -o "$model" "$@" || failed=1
done
exit $failed
