# Each is said in one line.
source "$QS_SOURCE/tests/tools/pm-serve/server.bash"
make-ball
"$QS_SOURCE/tests/tools/make-bumpy-ply" 12 | pm-build - -o other.pm
"$QS_SOURCE/tests/tools/make-bumpy-ply" 30 | qs-path orbit - --frames 2 > path.jsonl
start_server ball.pm other.pm
pm-fetch pm://./socket/ball --all --state ball.state
head -c 150 ball.state > cut.state
for words in "pm://./socket/none --all" "pm://./socket/ball" "pm://./socket/ball --all --path path.jsonl" "http://x/ball --all" \
    "pm://./nobody/ball --all" "pm://./socket/other --all --resume ball.state" "pm://./socket/ball --all --resume cut.state" \
    "pm://./socket/ball --all --resume ball.pm" "pm://./socket/ball --path path.jsonl --frame 2" \
    "pm://./socket/ball --all --resolution 0,5" "pm://./socket/ball --all --one-way --lists" \
    "pm://./socket/ball --all --one-way --resume ball.state"; do
    pm-fetch $words
    echo "status $?"
done
stop_server
sort -u server.log
