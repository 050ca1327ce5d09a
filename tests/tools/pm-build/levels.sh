# Every level is a mesh; its faces grow with it.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > bumpy.ply
pm-build bumpy.ply -o bumpy.pm
for level in 0 10 2.5% 50% full; do
    pm-build bumpy.pm --level $level -o level.ply --report - && qs-build level.ply -o level.qs && qs-info --verify level.qs
done
cat bumpy.ply | pm-build - -o - | pm-build - --level 100 -o - | head -c 3
