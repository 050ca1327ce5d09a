# systemd makes the socket and hands it over as descriptor 3: --listen has no say, and the socket stays when the server ends.
source "$QS_SOURCE/tests/tools/pm-serve/server.bash"
make-ball
cat > activate.py <<'EOF'
import os, socket, sys
listener = socket.socket(socket.AF_UNIX)
listener.bind("given")
if sys.argv[1] == "listening":
    listener.listen()
child = os.fork()
if child == 0:
    os.dup2(listener.fileno(), 3)
    os.set_inheritable(3, True)
    environment = dict(os.environ, LISTEN_PID=str(os.getpid()), LISTEN_FDS=sys.argv[2])
    os.execvpe("pm-serve", ["pm-serve", "ball.pm", "--listen", "./other"], environment)
open("pid", "w").write(str(child))
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
EOF
python3 activate.py listening 1 > ready &
starter=$!
until [[ -s ready ]]; do kill -0 $starter || exit 1; sleep 0.02; done
sed 's/given.*/given/; s/ .*given/ ...given/' ready
pm-fetch pm://./given/ball --all --report - | value splits
kill "$(cat pid)"
wait $starter
echo "ended with status $?; $(ls -d given other 2> /dev/null)"
for words in "listening 2" "silent 1"; do
    rm -f given
    python3 activate.py $words
    echo "status $?"
done
