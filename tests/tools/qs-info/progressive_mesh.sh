# Of a progressive mesh: text, JSON, the proof, a damaged one, and no cut.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 10 > bumpy.ply
pm-build bumpy.ply -o bumpy.pm
qs-info bumpy.pm
qs-info --json bumpy.pm | tr , '\n' | grep -c '"splits"'
qs-info --verify bumpy.pm - < bumpy.pm
qs-info --verify --json bumpy.pm
(head -c 5000 bumpy.pm; printf x; tail -c +5002 bumpy.pm) > damaged.pm
qs-info --verify damaged.pm bumpy.pm 2> message
echo "exit $?"
sed -E "s,[0-9a-f]{16},HASH,g" message
qs-info --cut 2 bumpy.pm -o cut.ply
echo "exit $?"
