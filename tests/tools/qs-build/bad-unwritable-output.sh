# Places where no file can be, for root either.
: > file
qs-build "$QS_DATA/mesh-ascii.ply" -o file/model.qs
echo "exit $?"
qs-build "$QS_DATA/mesh-ascii.ply" -o no/such/folder/model.qs
echo "exit $?"
mkdir model.qs
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
echo "exit $?"
ls -A . model.qs
