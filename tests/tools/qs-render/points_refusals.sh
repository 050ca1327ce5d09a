# What cannot be drawn from a server's points, and servers that are none.
for words in \
    "--ppve-command false -o a.png --threshold 2" \
    "--ppve-command false model.qs -o a.png" \
    "--ppve-command false" \
    "--ppve-command false -o a.png --ppve speed=3" \
    "--ppve-command false -o a.png --ppve size=12" \
    "--ppve-command false -o a.png --ppve scale=nan" \
    "--ppve-command false -o a.png --ppve memory=-5" \
    "--ppve-command false -o a.png --ppve codec=zip" \
    "--ppve-command false -o a.png --ppve-command= " \
    "a.ppve -o a.png" \
    "text.ppve -o a.png" \
    "cut.ppve -o a.png" \
    "--ppve-command false -o a.png" \
    "--ppve-command cat -o a.png --ppve timeout=0.2" \
    "--ppve-command uname -o a.png"; do
    echo "not a session" > text.ppve
    printf 'ppve-ses\1\0\0\0\1\0\0' > cut.ppve
    qs-render $words 2>&1
    echo "exit $?"
done
ls *.png 2> /dev/null
exit 0
