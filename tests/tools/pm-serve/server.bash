# Sourced by cases of pm-serve and pm-fetch: a model of a bumpy ball and a server in the working folder.
make-ball() { "$QS_SOURCE/tests/tools/make-bumpy-ply" 30 | pm-build - -o ball.pm; }
start_server() {
    rm -f ready
    pm-serve "$@" --listen ./socket > ready 2>> server.log &
    server=$!
    trap 'kill $server 2> /dev/null' EXIT
    until [[ -s ready ]]; do kill -0 $server || exit 1; sleep 0.02; done
}
stop_server() {
    kill $server
    wait $server
    echo "the server ends with status $?"
}
# The value of KEY in a line of JSON on standard input.
value() { grep -oE "\"$1\":[^,}]*" | cut -d: -f2; }
