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
unshare --mount bash -c '
    mount -t tmpfs -o size=1200k tmpfs disk || exit 77
    qs-path orbit model.qs --frames 20 -o path.jsonl
    # In the middle of a sequence, with --keep-going too: this is no frame that cannot be drawn.
    qs-render model.qs --path path.jsonl --resolution 256,256 --keep-going -o disk/frame-%04d.ppm 2> message
    echo "exit $?"
    sed "s/frame-00[0-9]*/frame-N/" message
    (($(find disk -type f | wc -l) >= 3)) && find disk -type f ! -size 196623c && rm disk/*
    # One file of all frames; depths; a report beside pictures that have room.
    qs-render model.qs --path path.jsonl --resolution 256,256 -o disk/all.y4m
    echo "exit $?"
    qs-render model.qs --path path.jsonl --resolution 256,256 --depth disk/%04d.pfm 2> message
    echo "exit $?"
    sed "s/00[0-9]*.pfm/N.pfm/" message
    find disk -type f -printf "%s\n" | sort -u
    rm -f disk/*
    head -c 1220k /dev/zero > disk/full 2> /dev/null
    qs-render model.qs --path path.jsonl --resolution 16,16 -o small-%d.ppm --report disk/report.jsonl
    echo "exit $?"
    ls disk' 2>&1
ls small-* | wc -l
