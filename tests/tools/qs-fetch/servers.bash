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
    for ((i = 0; i < 3000; ++i)); do
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

# ---- configurations of qs-hosting(7) ----

# The example of the page that begins with a line.
from_hosting_page() { # FIRST_LINE
    awk -v first="$1" '
        /^\.EX/ { at = NR }
        /^\.EE/ { inside = 0 }
        NR == at + 1 && $0 == first { inside = found = 1 }
        inside { gsub(/\\\(aq/, "\047"); gsub(/\\\(ha/, "^"); gsub(/\\-/, "-"); print }
        END { exit !found }' "$QS_SOURCE/man/qs-hosting.7" || echo "qs-hosting(7) has no example that begins with $1" >&2
}

# The page's configuration as this case can run it: other folders, ports, names and files of passwords.
hosting_config() { # FIRST_LINE
    from_hosting_page "$1" | sed -E -e "s|/srv/models|$PWD/www|g; s|/etc/ssl/models|$PWD/tls|g; s|/etc/[a-z0-9]+/models.users|$PWD/users|" \
        -e "s|https://models.example.org|https://127.0.0.1:$tls_port|; s|models.example.org|127.0.0.1|" \
        -e 's|https://\$host|https://127.0.0.1:TLS|; s|https://\$\{url.authority\}|https://127.0.0.1:TLS|' \
        -e "s|127.0.0.1:TLS|127.0.0.1:$tls_port|; s|listen 80;|listen 127.0.0.1:$port;|; s|listen 443|listen 127.0.0.1:$tls_port|" \
        -e "s|\*:80>|127.0.0.1:$port>|; s|\*:443>|127.0.0.1:$tls_port>|; s|\":443\"|\"127.0.0.1:$tls_port\"|"
}

# What the page's servers serve, and what they are asked with.
prepare_hosting() {
    needs openssl curl
    make_file model.qs 300001
    mkdir -p www/members www/partners tls
    cp www/model.qs www/members/
    cp www/model.qs www/partners/
    # Apache tags a file that changed within the last second weakly, and later otherwise.
    touch -d '1 hour ago' www/model.qs www/members/model.qs www/partners/model.qs
    openssl req -x509 -newkey rsa:2048 -nodes -days 2 -keyout tls/key.pem -out tls/chain.pem -subj /CN=localhost \
        -addext subjectAltName=IP:127.0.0.1 2> /dev/null
    echo "reader:$(openssl passwd -apr1 secret)" > users
    open_to_all www
    open_to_all users
    port=$(free_port) tls_port=$(free_port)
}

# Everything that the page promises of a server.
check_hosting() {
    local url=https://127.0.0.1:$tls_port
    ask() { curl -s --cacert tls/chain.pem -D head -o body "$@"; }
    field() { tr -d '\r' < head | sed -n "s/^$1: *//Ip"; }
    start_daemon --cacert tls/chain.pem --max-age 0
    for place in model.qs members/model.qs partners/model.qs; do
        fetch get "$url/$place" -o got 2>&1 | without_ports
        [[ -e got ]] && same got www/model.qs "$place for everybody" && rm got
    done
    fetch get "http://127.0.0.1:$port/model.qs" -o got && same got www/model.qs "by way of http"
    fetch stop
    from_hosting_page "machine models.example.org login reader password secret" | sed 's/models.example.org/127.0.0.1/' > .netrc
    from_hosting_page "https://models.example.org/partners/ Authorization: Bearer 0123456789" |
        sed "s/models.example.org/127.0.0.1:$tls_port/" > fields
    chmod 600 .netrc fields
    start_daemon --cacert tls/chain.pem --max-age 0 --headers fields
    fetch get "$url/members/model.qs" -o got && same got www/model.qs "by password"
    fetch get "$url/partners/model.qs" -o got && same got www/model.qs "by header field"
    ask -r 0-1023 -H 'Accept-Encoding: gzip' "$url/model.qs"
    cmp body <(head -c 1024 www/model.qs) && echo "range: $(head -n 1 head | grep -o 'HTTP/2 206'), $(field content-range), encoding: $(field content-encoding)"
    echo "caching: $(field cache-control); pages of $(field access-control-allow-origin) see $(field access-control-expose-headers)"
    ask -H "If-None-Match: $(field etag)" "$url/model.qs"
    echo "not changed: $(head -n 1 head | grep -o 'HTTP/2 304')"
    ask -X OPTIONS -H 'Origin: https://other.example' -H 'Access-Control-Request-Method: GET' "$url/model.qs"
    echo "pages may ask with: $(field access-control-allow-headers)"
    # In its place by a rename, and younger, as what is made later is.
    make_file next.qs 300001 2
    touch -d '1 minute' www/next.qs
    ask -r 0-0 "$url/model.qs"
    local before=$(field etag)
    mv www/next.qs www/model.qs
    # Servers that remember what they know of a file look again after a second or two.
    is_seen() { ask -r 0-0 "$url/model.qs"; [[ $(field etag) != "$before" ]]; }
    wait_for is_seen
    fetch get "$url/model.qs" -o got 2>&1 | without_ports
    same got www/model.qs "replaced"
    fetch stop
}

without_ports() { sed -E 's|127.0.0.1:[0-9]+|HOST|g'; }
