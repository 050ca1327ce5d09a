# The number of threads leaves no trace in a model.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 90 > mesh.ply
"$QS_SOURCE/tests/tools/make-bumpy-ply" 90 cloud > cloud.ply
for input in mesh cloud; do
    for threads in 1 2 16; do
        qs-build --threads "$threads" "$input.ply" -o "$input-$threads.qs"
    done
    cmp "$input-1.qs" "$input-2.qs" && cmp "$input-1.qs" "$input-16.qs" && echo "$input: same"
done
