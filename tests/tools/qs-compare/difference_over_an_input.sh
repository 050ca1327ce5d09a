. "$QS_SOURCE/tests/tools/picture"
picture a.ppm 01120110
cp a.ppm b.png
qs-compare a.ppm b.png --difference ./b.png
echo "status $?" >&2
cmp a.ppm b.png

# Folders, by whatever name, and single files of theirs.
mkdir one other differences
for folder in one other; do picture $folder/0.ppm 01120110; picture $folder/1.ppm 01120110; done
ln -s one link
ln -s ../other/1.ppm differences/1.ppm.png
for name in one ./other link one/../other differences; do
    qs-compare one other --difference $name
    echo "status $?" >&2
done
for name in one/0.ppm new/1.ppm.png; do
    qs-compare one other --difference new --report $name
    echo "status $?" >&2
done
qs-compare - b.png --difference c.png < a.ppm > /dev/null && qs-compare - b.png --difference c.png < c.png
[[ -e new ]] || echo "nothing made"
cmp one/0.ppm a.ppm && cmp other/1.ppm a.ppm
