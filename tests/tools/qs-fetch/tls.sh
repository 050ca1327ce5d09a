# A certificate that nobody vouches for is refused; with one that is trusted HTTP/2 is spoken.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs nginx openssl
make_file model.qs 3000001
openssl req -x509 -newkey rsa:2048 -nodes -days 2 -keyout key -out cert -subj /CN=localhost \
    -addext subjectAltName=IP:127.0.0.1 2> /dev/null
start_nginx "listen 127.0.0.1:PORT ssl http2;" "ssl_certificate $PWD/cert; ssl_certificate_key $PWD/key;"
start_daemon
fetch get "https://127.0.0.1:$port/model.qs" -o got 2>&1 | without_port
fetch stop
start_daemon --cacert cert
fetch get "https://127.0.0.1:$port/model.qs" -o got && same got www/model.qs "with the certificate"
grep -o 'HTTP/[0-9.]*' nginx/access.log | sort -u
fetch stop
# From https to http a redirect is not followed.
start_nginx "listen 127.0.0.1:PORT ssl;" "ssl_certificate $PWD/cert; ssl_certificate_key $PWD/key; return 302 http://127.0.0.1/;"
start_daemon --cacert cert
fetch get "https://127.0.0.1:$port/model.qs" -o got 2>&1 | without_port
