cp "$QS_DATA/tiny.ply" .
qs-build --memory 1M tiny.ply -o tiny.qs
status=$?
ls
exit $status
