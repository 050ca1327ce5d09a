# Names that meet in one file, of one frame or of two, are refused before anything is written; what goes to a
# device is not overwritten.
qs-build --quiet "$QS_DATA/tiny.ply" -o model.qs
qs-path orbit model.qs --frames 12 -o path.jsonl
mkdir d
ln -s d link
try() {
    qs-render model.qs --path path.jsonl --resolution 8,6 "$@" 2>&1 | head -n 1
    echo "exit ${PIPESTATUS[0]}"
}
try -o k-%d.ppm --depth k-%01d.ppm
try -o k-%d.ppm --depth k-1%d.ppm
try -o z-%d.png --report z-1.png
try -o z-%d.png --report ./z-11.png
try -o d/z-%d.png --depth link/z-%02d.png
try -o - --format rgb --depth z-%d.pfm --report z-0.pfm
try -o frames.y4m --report ./frames.y4m
find . | sort
try -o z-%d.png --report z-12.png
try -o one-%d.ppm --depth one-%d.pfm --report /dev/null
head -n 1 path.jsonl > still.jsonl
qs-render model.qs --path still.jsonl --resolution 8,6 --depth /dev/null --report /dev/null
find . -name 'z-*' | wc -l
# Standard output by another name; and standard input, which may be a file.
qs-render model.qs --path path.jsonl -o /dev/stdout --format y4m --report - 2>&1 | head -n 1
qs-render model.qs --path path.jsonl -o - --report /dev/fd/1 2>&1 | head -n 1
qs-render model.qs --path - -o path.jsonl --format y4m < path.jsonl 2>&1 | head -n 1
qs-render model.qs --path - -o a.y4m --report path.jsonl < path.jsonl 2>&1 | head -n 1
