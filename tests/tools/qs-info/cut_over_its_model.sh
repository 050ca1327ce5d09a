cp "$QS_DATA/tiny.qs" .
qs-info --cut 1 tiny.qs -o ./tiny.qs
status=$?
cmp tiny.qs "$QS_DATA/tiny.qs"
exit $status
