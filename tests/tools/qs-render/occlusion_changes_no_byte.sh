# A ball within a ball: the inner one is left out, and no picture or depth tells.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 120 | qs-build - -o model.qs
qs-path orbit model.qs --frames 3 --distance 0.8 -o path.jsonl
sum() { # KEY REPORT
    grep -o "\"$1\":[0-9]*" "$2" | cut -d: -f2 | awk "{ s += \$1 } END { print s }"
}
for splat in square circle ellipse smooth; do
    for occlusion in on auto off; do
        qs-render model.qs model.qs@0,0,0,0.5 --path path.jsonl --resolution 640,480 --splat "$splat" \
            --occlusion $occlusion --threshold 0.5 --quiet --format rgb -o $occlusion.rgb --depth $occlusion-%d.pfm \
            --report $occlusion.jsonl
    done
    cmp on.rgb off.rgb && cmp auto.rgb off.rgb && echo "$splat: the same pictures"
    for frame in 0 1 2; do cmp on-$frame.pfm off-$frame.pfm; done
    (($(sum occlusion off.jsonl) == 0 && $(sum occlusion on.jsonl) > 0)) || echo "$splat: nothing was hidden"
    ((10 * $(sum splats on.jsonl) < 9 * $(sum splats off.jsonl))) || echo "$splat: less than a tenth was hidden"
done
