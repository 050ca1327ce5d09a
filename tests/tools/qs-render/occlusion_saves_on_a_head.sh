# Of a head from a CT scan, skull within skin, at least 30 % of the splats are left out along each path, unasked.
scan=${QS_SHARED:-none}/ct-cranium-skin-bone.ply
[[ -e $scan ]] || { echo "no $scan"; exit 77; }
qs-build --quiet "$scan" -o head.qs
splats() {
    qs-render head.qs --path path.jsonl --quiet --occlusion "$1" --report - | grep -o '"splats":[0-9]*' | awk -F: '{ s += $2 } END { print s }'
}
for path in orbit dolly walk; do
    qs-path $path head.qs --frames 12 -o path.jsonl
    few=$(splats auto) all=$(splats off)
    ((100 * few <= 70 * all)) && echo "$path: 30 % are left out" || echo "$path: $few of $all are drawn"
done
