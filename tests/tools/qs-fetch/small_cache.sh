# The limit of the cache is kept to, and what is there stays right; a file that is larger than it is not got.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 3000001
make_file small.qs 1000000
start_nginx
start_daemon --limit 2M
url=http://127.0.0.1:$port
for i in 1 2 3 4 5; do
    fetch get "$url/small.qs?$i" -o got && cmp got www/small.qs
    (($(counter held_bytes) <= 2 << 20)) || echo "$(counter held_bytes) bytes are held"
done
# One, or two where the requests before were answered one by one.
(($(counter files_cached) > 0)) && echo "the last is kept"
fetch get "$url/model.qs" -o got --timeout 2s 2>&1 | without_port
(($(counter held_bytes) <= 2 << 20)) || echo "$(counter held_bytes) bytes are held"
# What nobody reads any more makes room.
fetch get "$url/small.qs?6" -o got && same got www/small.qs "after that"
