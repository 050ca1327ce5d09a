# For the cases of qs-fetch: servers on loopback, each with what it serves in www/, and a daemon with its cache in
# cache/.  All are ended with the case.

needs() {
    local program
    for program; do
        command -v "$program" > /dev/null || { echo "$program is not installed"; exit 77; }
    done
}

PATH=$PATH:/usr/sbin
started=()
trap 'for pid in "${started[@]}"; do kill "$pid" 2> /dev/null; wait "$pid" 2> /dev/null; done' EXIT

# A file of so many bytes that are the same each time, and do not repeat.
make_file() { # NAME BYTES [SEED]
    mkdir -p www
    python3 -c 'import random, sys; sys.stdout.buffer.write(random.Random(int(sys.argv[2])).randbytes(int(sys.argv[1])))' \
        "$2" "${3:-1}" > "www/$1"
}

free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

wait_for() { # COMMAND...
    local i
    for ((i = 0; i < 500; ++i)); do
        "$@" > /dev/null 2>&1 && return
        sleep 0.02
    done
    echo "never came true: $*"
    exit 1
}

answers() { (exec 3<> "/dev/tcp/127.0.0.1/$1"); } # PORT

start() { # COMMAND...
    "$@" > server.log 2>&1 &
    started+=($!)
}

# Workers run as the one who runs the test, and root must be named.
start_nginx() { # [LINES_OF_SERVER]
    needs nginx
    port=$(free_port)
    mkdir -p nginx
    local user=
    ((EUID)) || user='user root;'
    cat > nginx/conf << CONF
daemon off; worker_processes 1; pid $PWD/nginx/pid; error_log $PWD/nginx/error.log; $user
events {}
http {
    access_log $PWD/nginx/access.log;
    client_body_temp_path $PWD/nginx/1; proxy_temp_path $PWD/nginx/2; fastcgi_temp_path $PWD/nginx/3;
    uwsgi_temp_path $PWD/nginx/4; scgi_temp_path $PWD/nginx/5;
    server { ${1:-listen 127.0.0.1:$port;} root $PWD/www; ${2-} }
}
CONF
    sed -i "s/PORT/$port/" nginx/conf
    start nginx -c "$PWD/nginx/conf"
    wait_for answers "$port"
}

start_apache() {
    needs apache2
    port=$(free_port)
    mkdir -p apache
    local modules=/usr/lib/apache2/modules user=
    ((EUID)) || user=$'User www-data\nGroup www-data'
    cat > apache/conf << CONF
ServerRoot $PWD/apache
ServerName localhost
Listen 127.0.0.1:$port
PidFile $PWD/apache/pid
ErrorLog $PWD/apache/error.log
LoadModule mpm_event_module $modules/mod_mpm_event.so
LoadModule authz_core_module $modules/mod_authz_core.so
$user
DocumentRoot $PWD/www
CONF
    open_to_all www
    start apache2 -f "$PWD/apache/conf" -D FOREGROUND
    wait_for answers "$port"
}

start_lighttpd() {
    needs lighttpd
    port=$(free_port)
    printf 'server.document-root = "%s"\nserver.port = %d\nserver.bind = "127.0.0.1"\n' "$PWD/www" "$port" > lighttpd.conf
    start lighttpd -D -f "$PWD/lighttpd.conf"
    wait_for answers "$port"
}

# A server that gives up the rights of root must be able to come here.
open_to_all() {
    chmod -R a+rX "$1"
    local folder=$PWD
    until [[ $folder == / || $folder == /tmp ]]; do
        chmod a+x "$folder"
        folder=$(dirname "$folder")
    done
}

start_hostile() { # FILE [OTHER_FILE] [--tls CERTIFICATE KEY]
    needs python3
    rm -f hostile.port
    "$QS_SOURCE/tests/tools/hostile-server" "$@" > hostile.port 2> hostile.log &
    started+=($!)
    wait_for test -s hostile.port
    port=$(< hostile.port)
}

start_daemon() { # OPTIONS...
    qs-fetch serve --cache cache "$@" 2> daemon.log &
    daemon=$!
    started+=($daemon)
    wait_for test -S cache/socket
}

fetch() { qs-fetch "$1" --cache cache "${@:2}"; } # VERB ...

counter() { fetch status --json | python3 -c 'import json, sys; print(json.load(sys.stdin)[sys.argv[1]])' "$1"; } # KEY

# What was asked on a port that another run has not.
without_port() { sed "s/:$port/:PORT/g"; }

same() { cmp "$1" "$2" && echo "$3: same bytes"; } # FILE FILE NAME
