# A path that is split among processes gives the video that one process gives.
command -v ffmpeg > /dev/null || { echo "ffmpeg is not installed"; exit 77; }
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 | qs-build - -o ball.qs
qs-path orbit ball.qs --frames 5 -o orbit.jsonl
for workers in 1 3; do "$QS_SOURCE/examples/farm.sh" ball.qs orbit.jsonl $workers.mp4 $workers; done
for workers in 1 3; do ffmpeg -v error -i $workers.mp4 -f framemd5 - | grep -v '^#'; done | sort | uniq -c |
    awk '{ print $1 " times frame " ++n }'
