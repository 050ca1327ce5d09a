# A disk without space is told, and nothing wrong is left; with space again it goes on.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 3000001
start_hostile www/model.qs
mkdir cache
mount -t tmpfs -o size=2M,mode=700 none cache 2> /dev/null || { echo "needs the right to mount a file system"; exit 77; }
trap 'kill $daemon ${started[0]}; wait; umount cache' EXIT
start_daemon
url=http://127.0.0.1:$port/right
fetch get "$url" -o got --timeout 1s 2>&1 | without_port | sed "s|/[0-9a-f]*/data|/ID/data|"
mount -o remount,size=8M cache
fetch get "$url" -o got && same got www/model.qs "with more space"
