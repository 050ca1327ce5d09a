# What cannot be drawn while it arrives is refused with what to do instead.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs nginx
mkdir www
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > bumpy.ply
qs-build bumpy.ply -o www/model.qs
qs-build bumpy.ply --compress -o coded.qs
head -c -1 coded.qs > www/cut.qs
python3 -c 'import sys; b = bytearray(open("coded.qs", "rb").read()); b[len(b) // 2] ^= 128; open("www/flipped.qs", "wb").write(b)'
echo 'no model' > www/text.qs
start_nginx
start_daemon
url=http://127.0.0.1:$port
for arguments in "$url/cut.qs" "$url/flipped.qs" "$url/text.qs" "$url/none.qs" "www/model.qs --settle" "$url/model.qs --settle --realtime 5 --path p" \
    "$url/model.qs --realtime 5" "$url/model.qs --snapshot 1s,1s" "$url/model.qs --snapshot 1" "$url/model.qs --snapshot 1s --path p" \
    "$url/model.qs --order best" "$url/model.qs --magnify 1,2" "$url/model.qs --magnify 1,2,0" "$url/model.qs --sweep-base 1" \
    "$url/model.qs --plan --byte-budget 1K"; do
    qs-render $arguments --cache cache -o out.png 2>&1 | without_port
    echo "status ${PIPESTATUS[0]}"
done
