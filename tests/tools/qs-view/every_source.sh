# Every kind of source is opened and drawn to the end, to the picture of qs-render.
source "$QS_SOURCE/tests/tools/qs-view/display.bash"
for program in qs-build pm-build pm-serve ppve-sample qs-fetch; do
    command -v $program > /dev/null || { echo "no $program in this build"; exit 77; }
done
"$QS_SOURCE/tests/tools/make-bumpy-ply" 30 > ball.ply
qs-build ball.ply --leaf triangle -o ball.qs
pm-build ball.ply -o ball.pm
start_display
size=(--resolution 160,120)
shot() { # SOURCE
    qs-view "$@" "${size[@]}" --screenshot shot.png --report report.jsonl
    python3 -c 'import json
report = json.load(open("report.jsonl"))
assert report["opened_s"] <= report["first_picture_s"] <= report["complete_s"] and report["frames"] > 0, report'
}
drawn() { qs-render "$@" "${size[@]}" -o drawn.png; }

drawn ball.qs
shot ball.ply
cmp shot.png drawn.png && echo "a mesh is drawn as the model with its triangles"
drawn ball.qs ball.qs@0.5,0,0
shot ball.qs ball.qs@0.5,0,0
cmp shot.png drawn.png && echo "two models in one scene"

drawn ball.pm
shot ball.pm
cmp shot.png drawn.png && echo "a progressive mesh"
start pm-serve ball.pm --listen ./pm-socket
wait_for test -S pm-socket
drawn pm://./pm-socket/ball
shot pm://./pm-socket/ball
cmp shot.png drawn.png && echo "a progressive mesh at a server"

start ppve-sample ball.ply --listen ./ppve-socket
wait_for test -S ppve-socket
drawn ppve:./ppve-socket
shot ppve:./ppve-socket
qs-compare shot.png drawn.png --report - | python3 -c 'import json, sys
psnr = json.loads(sys.stdin.readline())["psnr_db"]
print("points of a server, as good:", psnr is None or psnr > 30)'

qs-build ball.ply -o plain.qs
"$QS_SOURCE/tests/tools/hostile-server" plain.qs > port 2> /dev/null &
started+=($!)
wait_for test -s port
drawn plain.qs
shot "http://127.0.0.1:$(< port)/right/plain.qs" --cache cache
cmp shot.png drawn.png && echo "a model at a web server"
qs-fetch stop --cache cache
