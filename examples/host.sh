#!/bin/bash
# Serves a folder of models with nginx, for qs-render, qs-view and qs-fetch on other machines, until it is ended.
#     examples/host.sh MODELS [PORT]
#
# Prints the address of each model. What a server on the open network should say beside this, caching and TLS among it,
# is in qs-hosting(7); this is its smallest form, without root.
set -euo pipefail
[ $# -ge 1 ] && [ $# -le 2 ] || { echo "usage: host.sh MODELS [PORT]" >&2; exit 2; }
models=$(realpath -e "$1") port=${2:-8080}
PATH=$PATH:/usr/sbin
work=$(mktemp -d)
trap 'kill %1 2>/dev/null; wait; rm -rf "$work"' EXIT
trap exit INT TERM
# Workers of nginx that root starts are somebody else, who must be able to read the models.
user=
[ "$(id -u)" -ne 0 ] || user='user root;'

cat >"$work/nginx.conf" <<CONF
$user
daemon off;
worker_processes 1;
pid $work/pid;
error_log stderr;
events {}
http {
    access_log off;
    client_body_temp_path $work/body;
    proxy_temp_path $work/proxy;
    fastcgi_temp_path $work/fastcgi;
    uwsgi_temp_path $work/uwsgi;
    scgi_temp_path $work/scgi;
    default_type application/octet-stream;
    keepalive_requests 100000; # a client asks for many ranges on one connection
    server {
        listen $port;
        root $models;
    }
}
CONF
# Said before the port answers, so that who waits for that finds the addresses complete.
for model in "$models"/*.qs; do echo "http://$(hostname):$port/$(basename "$model")"; done
nginx -e stderr -c "$work/nginx.conf" &
wait %1
