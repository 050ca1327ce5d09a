# lighttpd as qs-hosting(7) sets it up.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs lighttpd
[[ -e /usr/lib/lighttpd/mod_openssl.so ]] || { echo "lighttpd-mod-openssl is not installed"; exit 77; }
prepare_hosting
hosting_config "# /etc/lighttpd/conf-available/90-models.conf" > models.conf
# What Debian's own file says before it reads the others.
cat > lighttpd.conf << CONF
server.modules = ( "mod_indexfile", "mod_access", "mod_alias", "mod_redirect" )
server.document-root = "$PWD"
server.port = $port
server.bind = "127.0.0.1"
include_shell "/usr/share/lighttpd/create-mime.conf.pl"
include "$PWD/models.conf"
CONF
start lighttpd -D -f "$PWD/lighttpd.conf"
wait_for answers "$tls_port"
check_hosting
