# A ball within a ball: the inner one is left out, and no picture or depth tells.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 120 | qs-build - -o model.qs
qs-path orbit model.qs --frames 3 --distance 0.8 -o path.jsonl
for splat in square circle ellipse smooth; do
    for occlusion in on auto off; do
        qs-render model.qs model.qs@0,0,0,0.5 --path path.jsonl --resolution 640,480 --splat "$splat" --occlusion $occlusion \
            --threshold 0.5 --quiet -o - --format rgb --depth $occlusion-%d.pfm --report $occlusion.jsonl > $occlusion.rgb
    done
    cmp on.rgb off.rgb && cmp auto.rgb off.rgb && echo "$splat: the same pictures"
    for frame in 0 1 2; do cmp on-$frame.pfm off-$frame.pfm; done
    awk -F'[,:}]' '{ for (i = 1; i < NF; ++i) if ($i == "\"occlusion\"") culled[FILENAME] += $(i + 1)
                     else if ($i == "\"splats\"") splats[FILENAME] += $(i + 1) }
        END { print (culled["off.jsonl"] == 0 && culled["on.jsonl"] > 0 && splats["on.jsonl"] < 0.9 * splats["off.jsonl"]) ?
                    "a tenth of the splats is hidden at least" : "splats: " splats["on.jsonl"] " of " splats["off.jsonl"] }' \
        on.jsonl off.jsonl
done
