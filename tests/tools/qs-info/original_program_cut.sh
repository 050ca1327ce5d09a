cp "$QS_DATA/qsplat/colour.qs" .
qs-info --cut 2 colour.qs -o cut.ply
sed '/^end_header/q' cut.ply
qs-info --cut 0 colour.qs -o none.ply || qs-info --cut 4 colour.qs -o none.ply
ls
