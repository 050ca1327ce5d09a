# A progressive mesh is drawn the same from a file and from a server, by the CPU; finer ones are nearer to the input.
source "$QS_SOURCE/tests/tools/pm-serve/server.bash"
make-ball
"$QS_SOURCE/tests/tools/make-bumpy-ply" 30 > ball.ply
qs-path orbit ball.ply --frames 2 > path.jsonl
start_server ball.pm
for threshold in 0.5 3; do
    draw() { qs-render "$@" --path path.jsonl --resolution 160,120 --threshold $threshold --reference ball.ply; }
    draw ball.pm -o file-%d.png --report file.jsonl
    # Cones that it was not sent do not stop a client: what shows its back may be finer than it need be.
    draw pm://./socket/ball -o net-%d.png --report net.jsonl
    cmp file-0.png net-0.png && echo "the same first picture at $threshold"
    value triangles < file.jsonl > triangles
    value triangles < net.jsonl | paste - triangles | awk '$1 < $2 { print "fewer triangles from the server" }'
    cat file.jsonl net.jsonl | value measured_error_px | awk -v most=$threshold '{ print ($1 < 2 * most ? "near" : "far") " enough" }'
done
stop_server
qs-render ball.pm ball.pm -o x.png
qs-render ball.pm@1,2,3 -o x.png
qs-render ball.pm --budget 10ms -o x.png
qs-render pm://nowhere -o x.png
echo "status $?"
