cp "$QS_DATA/tiny.qs" .
qs-info --cut 3 tiny.qs -o cut.ply
status=$?
ls
exit $status
