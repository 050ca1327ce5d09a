"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > bumpy.ply
for threads in 1 2 7; do pm-build bumpy.ply -o $threads.pm --threads $threads; done
cmp 1.pm 2.pm && cmp 1.pm 7.pm
pm-build - -o - < bumpy.ply | cmp - 1.pm
ls
