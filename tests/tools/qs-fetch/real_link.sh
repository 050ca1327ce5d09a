# Over a link that the kernel makes slow, in a network of its own, a file comes whole, and the estimates are the link's.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs unshare ip tc curl nginx
if [[ ! -v inside ]]; then
    unshare --net true 2> /dev/null || { echo "needs the right to make a network namespace"; exit 77; }
    inside=1 exec unshare --net bash "$0"
fi
ip link set lo mtu 1500 up
tc qdisc add dev lo root netem delay 20ms rate 8mbit limit 1000 2> tc.err || { echo "tc cannot make netem: $(< tc.err)"; exit 77; }
make_file model.qs 1000001
start_nginx
start_daemon
fetch get "http://127.0.0.1:$port/model.qs" -o got && same got www/model.qs "8 Mbit/s, 40 ms"
fetch status --json | python3 -c 'import json, sys
server = json.load(sys.stdin)["servers"][0]
# Nothing comes faster than the link; a busy machine makes it slower.
print("rate within the link:", server["bytes_per_s"] <= 1.5e6)
print("round trip not below the link:", server["round_trip_ms"] >= 40)'
