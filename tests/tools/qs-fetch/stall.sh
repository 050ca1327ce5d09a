# A server that stops in the middle of an answer is asked again.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 100000
start_hostile www/model.qs
start_daemon --stall 1s
fetch get "http://127.0.0.1:$port/stall" -o got && same got www/model.qs stall
echo "retries: $(counter retries)"
