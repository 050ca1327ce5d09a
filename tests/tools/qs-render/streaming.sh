# Pictures of a model at a web server are those of the file once all is there, in whatever order it came; a second run
# fetches nothing; and a budget is kept to.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs nginx
mkdir www
"$QS_SOURCE/tests/tools/make-bumpy-ply" 120 > bumpy.ply
qs-build bumpy.ply -o www/model.qs
qs-build www/model.qs --compress -o www/coded.qs
start_nginx
start_daemon
url=http://127.0.0.1:$port/model.qs
view=(--camera-elevation-angle 30 --resolution 320,240 --threshold 2)
stream() { python3 -c 'import json, sys; print(*(json.loads(line)["stream"][sys.argv[1]] for line in sys.stdin))' "$1"; } # KEY
qs-render www/model.qs "${view[@]}" -o file.png

for order in gain level radius screen y sweep; do
    fetch evict > /dev/null
    qs-render "$url" --cache cache "${view[@]}" --order $order -o $order.png --report report.jsonl
    same file.png $order.png $order
done
qs-render "$url" --cache cache "${view[@]}" -o again.png --report - | stream bytes_fetched
same file.png again.png "second run"

for order in gain level; do
    fetch evict > /dev/null
    qs-render "http://127.0.0.1:$port/coded.qs" --cache cache "${view[@]}" --order $order -o coded.png --report report.jsonl
    same file.png coded.png "compressed, $order"
    (($(stream bytes_fetched < report.jsonl) < $(stat -c %s www/coded.qs))) || echo "more than the file"
done

for budget in 16384 30000; do
    fetch evict > /dev/null
    qs-render "$url" --cache cache "${view[@]}" --byte-budget $budget -o "budget-$budget.png" --report - |
        stream bytes_fetched > bytes
    echo "budget of $budget bytes kept: $(($(< bytes) <= budget && $(< bytes) > budget * 3 / 4))"
done

fetch evict > /dev/null
qs-render "$url" --cache cache "${view[@]}" --snapshot 0s,100ms,300ms -o snapshot-%d.png --report - | stream bytes_fetched |
    python3 -c 'b = [int(w) for w in input().split()]; print("snapshots:", len(b), b == sorted(b))'
ls snapshot-*.png

# The first of them may be later than the first blocks.
fetch evict > /dev/null
qs-render "$url" --cache cache "${view[@]}" --snapshot 150ms,200ms -o later-%d.png
ls later-*.png
