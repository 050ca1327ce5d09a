# A disk that is too small for the model: one line, and the half of a file is gone.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 100 > mesh.ply
mkdir disk
unshare --mount bash -c '
    mount -t tmpfs -o size=64k tmpfs disk || exit 77
    qs-build mesh.ply -o disk/model.qs 2> message
    echo "exit $?"
    cat message
    ls -A disk' 2> reason || { echo "cannot mount a small disk here"; exit 77; }
