# The units are right, and a daemon that systemd starts at the first connection serves it, and ends when it is idle.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs systemd-analyze systemd-socket-activate python3
mkdir -p units bin cache
chmod 700 cache
cp "$QS_SOURCE/share/systemd/qs-fetch.socket" units/
sed "s|@BINDIR@|$(dirname "$(command -v qs-fetch)")|" "$QS_SOURCE/share/systemd/qs-fetch.service.in" > units/qs-fetch.service
# It may complain about the machine's other units, and about manuals that are not installed yet.
XDG_RUNTIME_DIR=$PWD systemd-analyze --user --man=no verify ./units/qs-fetch.socket ./units/qs-fetch.service 2>&1 | grep -E 'qs-fetch|Failed'
make_file model.qs 100000
start_hostile www/model.qs
systemd-socket-activate --seqpacket --listen="$PWD/cache/socket" qs-fetch serve --cache cache --idle-exit 1s 2> daemon.log &
daemon=$!
started+=($daemon)
wait_for test -S cache/socket
fetch get "http://127.0.0.1:$port/right" -o got && same got www/model.qs "by a socket of systemd's"
wait $daemon
echo "ended with status $?"
