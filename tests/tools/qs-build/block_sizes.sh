for size in 1K 2K 64K; do
    qs-build --block-size $size "$QS_DATA/tiny.ply" -o tiny.qs
    stat -c %s tiny.qs
    qs-info --verify tiny.qs
done
