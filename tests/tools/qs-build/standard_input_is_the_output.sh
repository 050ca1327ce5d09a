# The shell has opened it already; it is neither read nor lost.
cp "$QS_DATA/mesh-ascii.ply" x
qs-build - -o x < x
echo "exit $?"
qs-build - -o model.qs --report x < x
echo "exit $?"
cmp x "$QS_DATA/mesh-ascii.ply" && ls
# Into the end of itself.
qs-build - -o - < x >> x
echo "exit $?"
qs-build x -o model.qs
# Two outputs into one standard output.
qs-build x -o - --report - | wc -c
qs-build x -o - --report /dev/stdout | wc -c
