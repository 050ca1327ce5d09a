# A folder is hosted; what comes from there is right; and a contact sheet shows it coming.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs nginx ffmpeg
mkdir www
"$QS_SOURCE/tests/tools/make-bumpy-ply" 40 | qs-build - -o www/ball.qs
open_to_all www
port=$(free_port)
"$QS_SOURCE/examples/host.sh" www "$port" > addresses 2> nginx.log &
started+=($!)
wait_for answers "$port"
sed 's,//.*:[0-9]*/,//HOST:PORT/,' addresses
url=http://127.0.0.1:$port/ball.qs
qs-fetch get "$url" --cache "$PWD/cache" -o got.qs && cmp got.qs www/ball.qs && echo "as it is"
qs-fetch stop --cache "$PWD/cache"
"$QS_SOURCE/examples/watch-stream.sh" "$url" sheet.png 4M 0.05 0.1 0.2 0.4
file sheet.png | grep -o '[0-9]* x [0-9]*'
