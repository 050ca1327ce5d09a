# Points of a server that is a command: drawn, recorded, and drawn again without the server, to the same bytes.
command -v ppve-sample > /dev/null || { echo "no ppve-sample in this build"; exit 77; }
"$QS_SOURCE"/tests/tools/examples-setup.sh scan.ply orbit.jsonl
draw() { qs-render "$@" --path orbit.jsonl --resolution 96,64; }
draw --ppve-command "ppve-sample scan.ply" --ppve record=session.ppve -o live-%d.png --report live.jsonl
draw session.ppve -o again-%d.png
for k in 0 1 2 3; do cmp live-$k.png again-$k.png; done
# Complete: what the mesh itself looks like, but for the rounding of normals.
draw --ppve-command "ppve-sample scan.ply" --ppve timeout=30 --reference scan.ply --report - |
    python3 -c 'import json, sys
for line in map(json.loads, sys.stdin):
    print(line["frame"], line["holes"], line["psnr_db"] > 24, line["updates"], line["out_of_step"])'
# For two eyes, as the server lights them, by the paper's rules; and while nothing is waited for.
draw --ppve-command "ppve-sample scan.ply" --stereo --ppve light=server,eliminate=paper,epsilon=0.01,codec=lzw -o both-%d.png
draw --ppve-command "ppve-sample scan.ply" --ppve realtime,size=64x48,points=1K,rule=1.5:0.3,velocity=8,closed -o moving-%d.png
ls *.png | wc -l
