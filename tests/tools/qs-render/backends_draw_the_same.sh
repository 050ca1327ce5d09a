# What --list-backends has draws, by its name, and as the CPU does; squares and ellipses but for rounding.
# The leak checker of address sanitizer cannot look at drivers' threads that end beside it.
export ASAN_OPTIONS="${ASAN_OPTIONS:+$ASAN_OPTIONS:}detect_leaks=0"
for name in osmesa egl; do
    qs-render --list-backends | grep "^$name  *not there" && exit 77
    for kind in square ellipse smooth; do
        for backend in cpu "$name"; do
            qs-render "$QS_DATA/bumpy.qs" --resolution 320,240 --splat $kind --backend "$backend" -o $backend.png \
                --depth $backend.pfm --report $backend.jsonl
        done
        grep -o '"backend":"[a-z]*"' $name.jsonl
        # Of smooth, the CPU's own frame depends on the order of the splats, and these are large.
        [[ $kind == smooth ]] && least=28 || least=55
        qs-compare $name.png cpu.png --min-psnr $least --max-holes 0 > compared && echo "$kind agrees" || cat compared
        qs-render "$QS_DATA/bumpy.qs" --resolution 320,240 --splat $kind --backend "$name" --threads 1 -o one.png
        cmp one.png $name.png
    done
done
