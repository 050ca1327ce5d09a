# A disk that is too small for the frames: one line, and nothing of a frame that did not fit.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
qs-path orbit model.qs --frames 3 -o path.jsonl
mkdir disk
unshare --mount bash -c '
    mount -t tmpfs -o size=256k tmpfs disk || exit 77
    qs-render model.qs --path path.jsonl --resolution 256,256 -o disk/frame-%04d.ppm 2> message
    echo "exit $?"
    sed "s/frame-000[0-2]/frame-N/" message
    # Frames are written side by side: one of them fits, or none.  What is there is whole.
    find disk -type f ! -size 196623c' 2> reason || { echo "cannot mount a small disk here"; exit 77; }
