# The system's clock may jump by years either way while the daemon runs: nothing waits, and nothing is lost.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs faketime
ldd "$(command -v qs-fetch)" | grep -qE 'lib[at]san' && { echo "the library that makes the clock jump does not go with sanitizers"; exit 77; }
make_file model.qs 300001
start_hostile www/model.qs
url=http://127.0.0.1:$port
set_clock() { echo "$1" > clock.new && mv clock.new clock; }
set_clock +0
# The steady clock goes on, as it does when a person sets the other one.
FAKETIME_TIMESTAMP_FILE=$PWD/clock FAKETIME_NO_CACHE=1 FAKETIME_DONT_FAKE_MONOTONIC=1 DONT_FAKE_MONOTONIC=1 \
    LD_PRELOAD=/usr/lib/$(uname -m)-linux-gnu/faketime/libfaketime.so.1 \
    qs-fetch serve --cache cache --limit-rate 2M 2> daemon.log &
daemon=$!
started+=($daemon)
wait_for test -S cache/socket
fetch get "$url/right" -o got &
getting=$!
for jump in +10y -10y +1h -1d +0; do
    sleep 0.15
    set_clock $jump
done
wait $getting && same got www/model.qs "while the clock jumped"
# What the server asks for in dates is held against a clock, and may not become a wait for years.
set_clock -10y
fetch get "$url/busy-until" -o got && same got www/model.qs "a server that was busy until a date"
set_clock +10y
fetch get "$url/right" -o got && same got www/model.qs "in ten years"
echo "blocks fetched twice: $(($(counter blocks_stored) - 2 * 293))"
