# What nginx, Apache and lighttpd serve comes whole, or as a range of it, and a second time without a request.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 3000001
needs nginx apache2 lighttpd
for server in nginx apache lighttpd; do
    rm -rf cache
    "start_$server"
    start_daemon
    url=http://127.0.0.1:$port/model.qs
    fetch get "$url" -o got && same got www/model.qs $server
    fetch get "$url" --range 1000-250000 -o got
    cmp got <(tail -c +1001 www/model.qs | head -c 249001) && echo "$server: same range"
    requests=$(counter requests)
    fetch get "$url" -o got && same got www/model.qs "$server again"
    echo "requests for it: $(($(counter requests) - requests)), bytes of the file: $(counter body_bytes)"
    fetch get "http://127.0.0.1:$port/none.qs" -o got 2>&1 | without_port
    kill $daemon
    wait $daemon && echo "ended with status 0"
    # Another daemon finds what the first one left.
    start_daemon
    fetch get "$url" -o got && same got www/model.qs "$server in the next run"
    echo "bytes for it: $(counter body_bytes)"
    fetch stop
done
