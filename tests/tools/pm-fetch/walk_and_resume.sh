# A walk goes through its path twice: the second time costs nothing.  Its state goes on at a restarted server.
source "$QS_SOURCE/tests/tools/pm-serve/server.bash"
make-ball
"$QS_SOURCE/tests/tools/make-bumpy-ply" 30 | qs-path walk - --frames 16 > walk.jsonl
start_server ball.pm
pm-fetch pm://./socket/ball --path walk.jsonl --report first.jsonl --state ball.state -o first.ply
echo "bytes of the second round: $(tail -n 8 first.jsonl | value bytes_down | paste -sd+ | bc) down, $(tail -n 8 first.jsonl | value bytes_up | paste -sd+ | bc) up"
stop_server
start_server ball.pm
pm-fetch pm://./socket/ball --path walk.jsonl --report again.jsonl --resume ball.state -o again.ply
cmp first.ply again.ply && echo "the same mesh"
echo "splits again: $(value splits_received < again.jsonl | sort -u)"
diff <(value faces < first.jsonl) <(value faces < again.jsonl) && echo "the same faces, frame by frame"
# A server of one model needs no name.
pm-fetch pm://./socket/ --all -o all.ply
pm-build ball.pm --level full -o full.ply
echo "all of it: $(head -n 20 all.ply | strings | grep '^element') for $(head -n 20 full.ply | strings | grep '^element')"
for service in --one-way --lists; do
    pm-fetch pm://./socket/ --all $service -o ./$service.ply --quiet
    diff <(head -n 20 all.ply | strings | grep '^element') <(head -n 20 -- ./$service.ply | strings | grep '^element') && echo "as much $service"
done
echo "sent: $(pm-serve --status ./socket | value splits_sent)"
stop_server
