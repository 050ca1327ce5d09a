cp "$QS_DATA/tiny.ply" .
qs-build tiny.ply --plain -o out.qs
