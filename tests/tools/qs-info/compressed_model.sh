qs-build "$QS_DATA/bumpy.qs" --compress -o small.qs --quiet
qs-info small.qs | grep -E '^(blocks|compressed|complete)'
# The nodes are the same.
qs-info --cut 3 small.qs -o - | cmp - <(qs-info --cut 3 "$QS_DATA/bumpy.qs" -o -)
