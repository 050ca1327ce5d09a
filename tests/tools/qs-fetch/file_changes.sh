# A file that is replaced at the server while it is fetched is never mixed; the next try gets the new one.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file old.qs 200000 1
make_file new.qs 200000 2
make_file shorter.qs 5000 3
start_hostile www/old.qs www/new.qs
start_daemon
for what in changing changing-tag changing-date; do
    fetch get "http://127.0.0.1:$port/$what" -o got 2>&1 | without_port
    test ! -e got && echo "nothing is written"
    fetch get "http://127.0.0.1:$port/$what" -o got && same got www/new.qs $what
    rm got
done
echo "files that changed: $(counter files_changed)"
# Without any validator the size tells.
start_hostile www/old.qs www/shorter.qs
fetch get "http://127.0.0.1:$port/changing-size" -o got 2>&1 | without_port
fetch get "http://127.0.0.1:$port/changing-size" -o got && same got www/shorter.qs changing-size
