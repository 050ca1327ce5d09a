# Every kind of source is opened and drawn to the end, to the picture of qs-render.
source "$QS_SOURCE/tests/tools/qs-view/display.bash"
source "$QS_SOURCE/tests/tools/qs-view/sources.bash"
make_balls
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
serve_mesh
drawn "$served_mesh"
shot "$served_mesh"
cmp shot.png drawn.png && echo "a progressive mesh at a server"

serve_points
drawn "$served_points"
shot "$served_points"
is_more "$(psnr shot.png drawn.png)" 30 && echo "points of a server, as good"

serve_model
drawn plain.qs
shot "$served_model" --cache cache
cmp shot.png drawn.png && echo "a model at a web server"
qs-fetch stop --cache cache
