# A cache belongs to one daemon, one user and one folder, and says so.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 100000
start_hostile www/model.qs
url=http://127.0.0.1:$port/right
start_daemon
qs-fetch serve --cache cache 2>&1 | sed "s/process $daemon/process PID/"
mkdir open && chmod 755 open
qs-fetch serve --cache open
touch file
qs-fetch serve --cache file
qs-fetch serve --cache other --limit 0
fetch get "$url" -o got && same got www/model.qs "the first daemon"
rm -rf cache
qs-fetch status --cache cache
rmdir cache
kill $daemon; wait $daemon
# A verb starts a daemon of its own, which ends when it is not needed; here it is told to.
fetch get "$url" -o got && same got www/model.qs "a private daemon"
fetch evict "$url" && fetch prefetch "$url" --bytes 50K && counter blocks_stored
fetch evict && counter held_bytes
fetch stop
qs-fetch status --cache cache
