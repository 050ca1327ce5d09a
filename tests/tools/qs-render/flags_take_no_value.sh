# "--stereo=no" is neither with nor without.
for program in "qs-build x -o y --skip-bad=yes" "qs-info x --json=1" "qs-path spline x --closed=false" "qs-compare x y --json=" \
    "qs-render x -o y.png --stereo=no" "qs-render --list-backends=x" "qs-render x --keep-going=0" "qs-path orbit x --quiet=no"; do
    $program
    echo "exit $?"
done 2>&1 | grep -v "^try"
