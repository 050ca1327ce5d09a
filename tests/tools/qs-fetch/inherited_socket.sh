# systemd's socket is listened on, and another user who can reach it is refused.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs python3
python3 - << 'CHECK'
import json, os, signal, socket, struct, sys, time
os.umask(0)
listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
listener.bind("socket")
listener.listen()
pid = os.fork()
if pid == 0:
    os.dup2(listener.fileno(), 3)
    os.set_inheritable(3, True)
    environment = dict(os.environ, LISTEN_PID=str(os.getpid()), LISTEN_FDS="1")
    os.dup2(os.open("daemon.log", os.O_WRONLY | os.O_CREAT), 2)
    os.execvpe("qs-fetch", ["qs-fetch", "serve", "--cache", "cache"], environment)
folder = os.open(".", os.O_PATH)

def status():
    client = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    client.settimeout(20)
    client.connect(f"/proc/self/fd/{folder}/socket")
    client.send(struct.pack("<I", 4))
    return client.recv(65536)

print("clients:", json.loads(status()[8:])["clients"])
child = os.fork()
if child == 0:
    try:
        os.chmod(".", 0o755)
        os.setuid(65534)
    except PermissionError:
        os._exit(77)
    try:
        os._exit(len(status()) > 0)
    except (ConnectionResetError, BrokenPipeError):
        os._exit(0)
_, how = os.waitpid(child, 0)
code = os.waitstatus_to_exitcode(how)
os.kill(pid, signal.SIGTERM)
_, ended = os.waitpid(pid, 0)
if code == 77:
    print("needs root, to be another user")
    sys.exit(77)
print("answers for another user:", code)
print("ended with status", os.waitstatus_to_exitcode(ended))
CHECK
