# A cache that is removed, or made read-only, while the daemon runs is said, and what was right stays right.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 300001
start_hostile www/model.qs
url=http://127.0.0.1:$port
start_daemon
fetch get "$url/right" -o got
python3 - "$url" << 'CHECK'
# A client that has the file open while the folder goes.
import os, shutil, socket, struct, sys
def connect():
    client = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    client.settimeout(20)
    client.connect("cache/socket")
    return client
def open_file(client, stream, path):
    client.send(struct.pack("<III", 1, 1, stream) + (sys.argv[1] + path).encode())
    message, control, _, _ = client.recvmsg(65536, socket.CMSG_SPACE(12))
    fds = struct.unpack("<3i", control[0][2]) if control else ()
    return message, fds
client = connect()
_, fds = open_file(client, 1, "/right")
shutil.rmtree("cache")
print("the file that is open:", os.pread(fds[0], 1000, 5000) == open("www/model.qs", "rb").read()[5000:6000])
message, fds = open_file(client, 2, "/to-right")
print("another file:", message[12:].decode().replace(sys.argv[1], "") if not fds else "opened")
CHECK
kill $daemon && wait $daemon && echo "ended with status 0"
start_daemon
fetch get "$url/right" -o got && same got www/model.qs "a new one"
fetch stop

# A folder that may not be written to; root must be made to mind.
minding=()
((EUID)) || minding=(setpriv --bounding-set -dac_override,-dac_read_search)
needs setpriv
"${minding[@]}" qs-fetch serve --cache cache 2> daemon.log &
daemon=$!
started+=($daemon)
wait_for test -S cache/socket
fetch get "$url/right" --range 0-99999 -o got
chmod 500 cache
fetch get "$url/to-right" -o got 2>&1 | without_port
fetch get "$url/right" -o got && same got www/model.qs "what is there, and the rest of it,"
chmod 700 cache
fetch get "$url/to-right" -o got && same got www/model.qs "when it may be written to"
