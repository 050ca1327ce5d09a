# A disk that cannot be written, not even by root.
mkdir disk
unshare --mount bash -c '
    mount -t tmpfs -o ro tmpfs disk || exit 77
    qs-build "$QS_DATA/mesh-ascii.ply" -o disk/model.qs 2> message
    echo "exit $?"
    cat message' 2> reason || { echo "cannot mount a read-only disk here"; exit 77; }
