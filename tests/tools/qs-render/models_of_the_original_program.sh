# Drawn as the model that qs-build makes of them.
cp "$QS_DATA/qsplat/colour.qs" old.qs
qs-build old.qs -o new.qs
camera=(--resolution 96,64 --camera-position 1,2,60 --camera-focal-point 1,2,3)
qs-render old.qs "${camera[@]}" -o old.png --verbose 2>&1 | grep -o 'a model of the original QSplat'
qs-render new.qs "${camera[@]}" -o new.png
cmp old.png new.png
qs-render - "${camera[@]}" -o piped.png < old.qs
cmp old.png piped.png
head -c 100 old.qs > short.qs
qs-render short.qs "${camera[@]}" -o none.png
