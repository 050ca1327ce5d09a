# systemd's socket is served instead of --listen's, which is not made, and a socket of another kind is refused.
cp "$QS_DATA/mesh-ascii.ply" a.ply
python3 - << 'CHECK'
import os, signal, socket, struct

def serve(kind, log):
    listener = socket.socket(socket.AF_UNIX, kind)
    listener.bind(log + ".socket")
    listener.listen()
    pid = os.fork()
    if pid == 0:
        os.dup2(listener.fileno(), 3)
        os.set_inheritable(3, True)
        os.dup2(os.open(log, os.O_WRONLY | os.O_CREAT), 2)
        environment = dict(os.environ, LISTEN_PID=str(os.getpid()), LISTEN_FDS="1")
        os.execvpe("ppve-sample", ["ppve-sample", "--listen", "./other.socket", "a.ply"], environment)
    return pid

pid = serve(socket.SOCK_STREAM, "stream")
client = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
client.settimeout(20)
client.connect("stream.socket")
size, = struct.unpack("<I", client.recv(4, socket.MSG_WAITALL))
print("a welcome:", client.recv(size, socket.MSG_WAITALL)[:3].hex())
print("another socket:", os.path.exists("other.socket"))
os.kill(pid, signal.SIGTERM)
print("ends with status", os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
print("of messages: status", os.waitstatus_to_exitcode(os.waitpid(serve(socket.SOCK_SEQPACKET, "messages"), 0)[1]))
print(open("messages").read(), end="")
CHECK
