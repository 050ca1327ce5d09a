# --frames, --tile, --samples, --stereo, --budget and --refine in all combinations: the pictures are parts of those
# without, and a budget (that is large enough) and refinement change none of them.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 40 | qs-build --quiet - -o model.qs
qs-path orbit model.qs --frames 3 -o path.jsonl
draw() { qs-render model.qs --path path.jsonl --resolution 40,30 --quiet --threshold 2 --format rgb "$@"; }
row=$((3 * 40))
same() { # TILE FILE WHOLE: the tile is the middle third of the rows
    if [[ $1 ]]; then cmp "$2" <(tail -c +$((10 * row + 1)) "$3" | head -c $((10 * row))); else cmp "$2" "$3"; fi
}
drawn=0 refused=0
for samples in "" "--samples 4"; do
    for stereo in "" --stereo; do
        name=%d.rgb eyes=all
        [[ $stereo ]] && name=%s-%d.rgb eyes="left right"
        rm -rf whole
        mkdir whole
        draw $samples $stereo -o whole/$name
        for tile in "" "--tile 0,1/1,3"; do
            for frames in "" "--frames 1:2"; do
                for budget in "" "--budget 60s"; do
                    for refine in "" --refine; do
                        rm -f ./*.rgb
                        if ! draw $samples $stereo $tile $frames $budget $refine -o $name 2> said; then
                            [[ $tile && $budget ]] && ((++refused)) || cat said
                            continue
                        fi
                        for eye in $eyes; do
                            for frame in 0 1 2; do
                                file=${eye#all}${stereo:+-}$frame.rgb
                                if [[ $frames && $frame != 1 ]]; then
                                    [[ ! -e $file ]] || echo "$file of another frame"
                                else
                                    same "$tile" "$file" "whole/$file" && ((++drawn))
                                fi
                            done
                        done
                    done
                done
            done
        done
    done
done
echo "$drawn pictures as they should be, $refused combinations refused"
cat said
draw --tile 0,0/1,3 --stereo -o both.rgb
# All but the tile, side by side in a stream; the report has a line for each eye and refinement.
draw --frames 1: --samples 4 --stereo --budget 60s --refine --report report.jsonl
grep -c '"budget_ms"' report.jsonl
draw --frames 1: --samples 4 --stereo --refine -o - --report report.jsonl | wc -c
grep -oE '"frame":[0-9]+,"eye":"[a-z]+"' report.jsonl | uniq -c | awk '{ print $2, ($1 > 1) ? "refined" : "once" }'
