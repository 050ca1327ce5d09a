# Inputs that are not there, are no file, or are nothing.
qs-build missing.ply -o model.qs
echo "exit $?"
qs-build . -o model.qs
echo "exit $?"
qs-build - -o model.qs < /dev/null
echo "exit $?"
ls -A
