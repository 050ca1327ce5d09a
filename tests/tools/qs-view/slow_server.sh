# A window waits for nobody: not for a server that is silent, not for one that is lost, and it closes at once.
source "$QS_SOURCE/tests/tools/qs-view/display.bash"
for program in pm-build pm-serve qs-fetch; do
    command -v $program > /dev/null || { echo "no $program in this build"; exit 77; }
done
# Accepts and says nothing.
python3 -c 'import socket, sys, time
s = socket.create_server(("127.0.0.1", 0))
print(s.getsockname()[1], flush=True)
time.sleep(60)' > port &
started+=($!)
wait_for test -s port
start_display
value() { python3 -c 'import json, sys; print(json.load(open("report.jsonl"))[sys.argv[1]])' "$1"; }
start_viewer "http://127.0.0.1:$(< port)/model.qs" --cache cache --resolution 320,240 --report report.jsonl
sleep 10
begun=$(date +%s%N)
press_keys F1 Escape q
end_viewer
echo "closed in time: $((($(date +%s%N) - begun) / 1000000 < 30000))"
echo "opened: $(value opened_s)"
python3 -c 'import json
report = json.load(open("report.jsonl"))
print("frames went on:", report["frames"] > 5)'
qs-fetch stop --cache cache

# The server of a mesh is lost: what has come can still be turned, the window resized, hidden and shown.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 30 | pm-build - -o ball.pm
start pm-serve ball.pm --listen ./socket
wait_for test -S socket
start_viewer pm://./socket/ball --resolution 320,240 --report report.jsonl
then_says 0 "picture complete"
kill "${started[-2]}"
press_keys Left Left
sleep 0.5
window=$(xdotool search --name "^qs-view")
xdotool windowunmap --sync "$window" windowmap --sync "$window" windowsize --sync "$window" 200 150 windowfocus "$window"
press_keys Up p
wait_for test -s view.out
press_keys s
wait_for test -s qs-view-0001.png
qs-render ball.pm --path view.out --resolution 200,150 -o whole.png
qs-compare qs-view-0001.png whole.png --report - | python3 -c 'import json, sys
psnr = json.loads(sys.stdin.readline())["psnr_db"]
print("what had come is turned:", psnr is None or psnr > 20)'
python3 -c 'import struct
print("of the new size:", struct.unpack(">II", open("qs-view-0001.png", "rb").read()[16:24]))'
press_keys q
end_viewer
