# Python's plain server knows no ranges: that is said at once, and nothing is downloaded.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 3000001
port=$(free_port)
start python3 -m http.server "$port" --bind 127.0.0.1 --directory www
wait_for answers "$port"
start_daemon
for i in 1 2 3; do fetch get "http://127.0.0.1:$port/model.qs" -o got 2>&1 | without_port; done
echo "requests: $(counter requests), bytes: $(counter body_bytes)"
test ! -e got && echo "nothing is written"
