# A server's counters before and after a picture; the man page knows each of them.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 30 > a.ply
ppve-sample --verbose --listen ./socket a.ply 2> ready & server=$!
trap 'kill $server 2> /dev/null' EXIT
until [[ -s ready ]]; do kill -0 $server || exit 1; sleep 0.02; done
ppve-sample --status ./socket > before
qs-render ppve:./socket --resolution 64,48 -o a.png --quiet
ppve-sample --status ./socket > after
python3 - "$QS_SOURCE/man/ppve-sample.1" << 'CHECK'
import json, re, sys
before, after = (json.load(open(name)) for name in ("before", "after"))
print("before:", before["clients"], before["clients_seen"], before["updates"], before["samples"])
print("after:", after["clients_seen"], after["updates"] > 0, after["updates"] == after["requests"] - after["requests_replaced"])
print("touched:", 0 < after["scene_bytes_touched_most"] <= after["scene_bytes"])
page = re.sub(r'["\\,]', " ", open(sys.argv[1]).read()).split()
print("unknown to the page:", [key for key in after if key not in page])
CHECK
try() { ppve-sample "$@" > out; echo "$?"; }
try --status ./nowhere
try --status nowhere
try --status ./socket a.ply
try
kill $server
wait $server
echo "the server ends with status $?"
