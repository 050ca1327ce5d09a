# For the cases that open every kind of source: one small ball as each of them.  The functions that start servers set
# what the source is called.
for program in qs-build pm-build pm-serve ppve-sample qs-fetch; do
    command -v $program > /dev/null || { echo "no $program in this build"; exit 77; }
done

make_balls() {
    "$QS_SOURCE/tests/tools/make-bumpy-ply" 30 > ball.ply
    qs-build ball.ply --leaf triangle -o ball.qs
    qs-build ball.ply -o plain.qs
    pm-build ball.ply -o ball.pm
}

serve_mesh() {
    start pm-serve ball.pm --listen ./pm-socket
    wait_for test -S pm-socket
    served_mesh=pm://./pm-socket/ball
}

serve_points() {
    start ppve-sample ball.ply --listen ./ppve-socket
    wait_for test -S ppve-socket
    served_points=ppve:./ppve-socket
}

# plain.qs; fetched with --cache cache, whose daemon the case stops.
serve_model() {
    "$QS_SOURCE/tests/tools/hostile-server" plain.qs > port 2> /dev/null &
    started+=($!)
    wait_for test -s port
    served_model=http://127.0.0.1:$(< port)/right/plain.qs
}

psnr() { # PICTURE PICTURE prints dB; inf: they are the same
    qs-compare "$1" "$2" --report - | python3 -c 'import json, sys; print(json.loads(sys.stdin.readline())["psnr_db"] or "inf")'
}

is_more() { python3 -c 'import sys; sys.exit(not float(sys.argv[1]) > float(sys.argv[2]))' "$1" "$2"; }
