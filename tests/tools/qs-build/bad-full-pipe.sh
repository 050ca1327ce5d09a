# A full disk behind standard output.
qs-build "$QS_DATA/mesh-ascii.ply" -o - > /dev/full
