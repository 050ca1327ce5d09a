# Models of odd files from the wild are drawn, each with something in its picture.
[[ -d ${QS_SHARED:-}/odd ]] || { echo "no folder of odd files"; exit 77; }
for path in "$QS_SHARED"/odd/*; do
    timeout 60 qs-build --quiet "$path" -o model.qs 2> /dev/null || continue
    timeout 60 qs-render model.qs -o frame.ppm --resolution 160,120 --background 1,2,3
    status=$?
    colours=$(tail -c $((3 * 160 * 120)) frame.ppm | od -An -v -tu1 -w3 | sort -u | wc -l)
    echo "${path##*/}: exit $status, $( ((colours > 1)) && echo drawn || echo empty)"
    rm -f frame.ppm model.qs
done
ls
