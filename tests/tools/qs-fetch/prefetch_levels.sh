# The first levels of a model are what qs-info says that they take, and nothing more is fetched.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs curl
mkdir www
"$QS_SOURCE/tests/tools/make-bumpy-ply" 160 > www/mesh.ply
qs-build www/mesh.ply -o www/model.qs
start_hostile www/model.qs
start_daemon
fetch prefetch "http://127.0.0.1:$port/right" --levels 5 --report prefetch.json
qs-info --json www/model.qs > info.json
python3 -c 'import json
levels = json.load(open("info.json"))["levels"]
got = json.load(open("prefetch.json"))["bytes"]
wanted = max(level["prefix_bytes"] for level in levels[:6])
print("as many bytes as they take:", got == wanted)'
sent=$(curl -s "http://127.0.0.1:$port/bytes/right")
python3 -c 'import json, sys
got = json.load(open("prefetch.json"))
# Blocks of the model are blocks of the cache.
print("sent no more:", int(sys.argv[1]) == got["bytes"])
print("less than the file:", got["bytes"] < 0.9 * got["file_bytes"])' "$sent"
start_hostile www/mesh.ply
fetch prefetch "http://127.0.0.1:$port/right" --levels 4 2>&1 | without_port
fetch prefetch "http://127.0.0.1:$port/right"
