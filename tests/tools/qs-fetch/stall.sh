# A server that stops in the middle of an answer is asked again, after the time that was given.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs curl
make_file model.qs 100000
start_hostile www/model.qs
start_daemon --stall 1s
fetch get "http://127.0.0.1:$port/stall" -o got && same got www/model.qs stall
echo "retries: $(counter retries)"
hung_up() { [[ $(curl -s "http://127.0.0.1:$port/waited/stall") != 0 ]]; }
wait_for hung_up
# Much more than a second would be another clock than that of the request; four are a busy machine's.
curl -s "http://127.0.0.1:$port/waited/stall" | awk '{ print (0.9 < $1 && $1 < 4) ? "given up in time" : "given up after " $1 " s" }'
