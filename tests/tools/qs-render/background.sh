# The corner of the picture, in decimal and hexadecimal.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
for colour in 16,32,255 "#1020ff"; do
    qs-render model.qs --resolution 64,48 --format rgb --background "$colour" -o - | od -An -tu1 -N3
done
