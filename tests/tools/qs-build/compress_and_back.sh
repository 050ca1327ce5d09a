# Each way gives back what the other began with; from a mesh it is the same; and it is smaller.
qs-build "$QS_DATA/bumpy.qs" --compress -o small.qs --quiet
qs-info --verify small.qs
qs-build small.qs --plain -o - --quiet | cmp - "$QS_DATA/bumpy.qs"
qs-build small.qs --compress -o again.qs --quiet
cmp small.qs again.qs
[ $(stat -c %s small.qs) -lt $(stat -c %s "$QS_DATA/bumpy.qs") ]
for size in 1K 4K; do
    qs-build "$QS_DATA/mesh-normals-colours.ply" --block-size $size -o plain.qs --quiet
    qs-build plain.qs --compress -o recoded.qs --quiet
    qs-build "$QS_DATA/mesh-normals-colours.ply" --block-size $size --compress -o direct.qs --quiet
    cmp recoded.qs direct.qs
done
qs-build "$QS_DATA/bumpy.qs" --compress -o one.qs --threads 1 --quiet
qs-build "$QS_DATA/bumpy.qs" --compress -o many.qs --threads 8 --quiet
cmp one.qs many.qs
