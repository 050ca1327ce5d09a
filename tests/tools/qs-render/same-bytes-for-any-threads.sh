# The number of threads leaves no trace in a frame.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > mesh.ply
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 cloud > cloud.ply
for input in mesh cloud; do
    qs-build "$input.ply" -o "$input.qs"
    qs-path orbit "$input.qs" --frames 3 -o path.jsonl
    for splat in square circle ellipse smooth; do
        for threads in 1 2 16; do
            qs-render --threads "$threads" "$input.qs" --path path.jsonl --resolution 320,240 --splat "$splat" \
                -o "%04d-$threads.png" --depth "%04d-$threads.pfm"
        done
        for frame in 0000 0001 0002; do
            for kind in png pfm; do
                cmp "$frame-1.$kind" "$frame-2.$kind" && cmp "$frame-1.$kind" "$frame-16.$kind" ||
                    echo "$input, $splat, frame $frame: $kind differs"
            done
        done
        rm -f ./*.png ./*.pfm
    done
    echo "$input: done"
done
