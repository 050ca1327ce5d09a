# Of a URL the header and the first picture are fetched, plain or compressed; what needs the file says so.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs nginx
mkdir www
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > bumpy.ply
qs-build bumpy.ply -o www/model.qs
qs-build www/model.qs --compress -o www/coded.qs
echo 'no model' > www/text.qs
start_nginx
start_daemon
url=http://127.0.0.1:$port
for name in model coded; do
    qs-info "$url/$name.qs" --cache cache --json |
        python3 -c 'import json, sys; i = json.load(sys.stdin); [i.pop(k) for k in ("file",)]; print(json.dumps(i))' > remote
    head -c 13K www/$name.qs | qs-info - --json |
        python3 -c 'import json, sys; i = json.load(sys.stdin); [i.pop(k) for k in ("file",)]; print(json.dumps(i))' > local
    same remote local "$name"
    cmp <(qs-path orbit "$url/$name.qs" --cache cache --frames 3) <(qs-path orbit www/$name.qs --frames 3) && echo "$name: same path"
done
echo "fetched: $(counter body_bytes)"
for words in "--verify $url/model.qs" "--cut 2 $url/model.qs -o out.ply" "$url/text.qs" "$url/none.qs"; do
    qs-info $words --cache cache 2>&1 | without_port
    echo "status ${PIPESTATUS[0]}"
done
