# What is in the cache is asked about, when it is opened, once the server has not confirmed it for --max-age.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs curl
make_file old.qs 100000 1
make_file new.qs 100000 2
make_file longer.qs 100001 3
start_hostile www/old.qs www/new.qs
url=http://127.0.0.1:$port
requests() { curl -s "$url/count/$1"; }

start_daemon
fetch get "$url/uncomparing" -o got && before=$(requests uncomparing)
fetch get "$url/uncomparing" -o got && echo "younger: $(($(requests uncomparing) - before)) requests"
# Of the file's last confirmation, in the past, and in the future of a clock that was set back since.
for time in '20 minutes ago' '5 minutes ago' '3 years'; do
    fetch stop
    touch -d "$time" cache/*/facts
    start_daemon
    before=$(requests uncomparing)
    fetch get "$url/uncomparing" -o got && same got www/old.qs "confirmed $time"
    fetch get "$url/uncomparing" -o got
    echo "requests: $(($(requests uncomparing) - before)), checks: $(counter checks)"
done
fetch stop

start_daemon --max-age 0
fetch get "$url/right" -o got
fetch get "$url/right" -o got && echo "checks with --max-age 0: $(counter checks)"
fetch get "$url/renewed" -o got && same got www/old.qs "before"
fetch get "$url/renewed" -o got 2>&1 | without_port
same got www/new.qs "replaced meanwhile"
fetch get "$url/renewed" -o got && same got www/new.qs "not replaced again"
echo "files that changed: $(counter files_changed)"
fetch get "$url/withdrawn" -o got
fetch get "$url/withdrawn" -o got 2>&1 | without_port

# What cannot be asked is served from the cache, and that is said.
kill "${started[0]}" && wait "${started[0]}" 2> /dev/null
fetch get "$url/right" -o got 2>&1 | without_port
same got www/old.qs "without the server"
fetch stop

# Without any validator the size tells.
start_hostile www/old.qs www/longer.qs
start_daemon --max-age 0
fetch get "http://127.0.0.1:$port/renewed-unnamed" -o got && same got www/old.qs "before"
fetch get "http://127.0.0.1:$port/renewed-unnamed" -o got 2>&1 | without_port
same got www/longer.qs "replaced by a longer one"
