# Odd files from the wild, with triangles as leaves: the valid ones become models that verify, the others are refused.
[[ -d ${QS_SHARED:-}/odd ]] || { echo "no folder of odd files"; exit 77; }
for path in "$QS_SHARED"/odd/*; do
    file=${path##*/}
    [[ $file == *.md || $file == *.json ]] && continue
    cp "$path" .
    if timeout 60 qs-build --quiet --leaf triangle "$file" -o model.qs 2> message; then
        qs-info --verify model.qs > /dev/null && echo "$file: built"
    else
        echo "exit $? $(cat message)"
    fi
    rm -f "$file" model.qs
done
ls
