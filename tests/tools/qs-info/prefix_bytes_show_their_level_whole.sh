# For each level, so many bytes as are printed for it hold the level, and a byte less does not.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 24 | qs-build --quiet - -o model.qs
lines() { qs-info "$@" | sed '1,/^level  /d'; }
lines model.qs > whole
while read -r level nodes leaves radius_mean radius_max error_mean error_max prefix; do
    head -c "$prefix" model.qs | lines - | sed -n "$((level + 1))p" > got
    sed -n "$((level + 1))p" whole | cmp - got
    head -c "$((prefix - 1))" model.qs > less.qs
    lines less.qs 2> /dev/null | sed -n "$((level + 1))p" | cmp -s got && echo "level $level needs less than $prefix bytes"
done < whole
[ -s whole ]
