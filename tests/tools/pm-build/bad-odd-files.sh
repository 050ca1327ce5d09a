# Odd files from the wild: meshes become models that verify, whatever is wrong with them; the rest is refused.
[[ -d ${QS_SHARED:-}/odd ]] || { echo "no folder of odd files"; exit 77; }
for path in "$QS_SHARED"/odd/*; do
    file=${path##*/}
    [[ $file == *.md || $file == *.json ]] && continue
    cp "$path" .
    if timeout 60 pm-build --quiet "$file" -o model.pm 2> message; then
        qs-info --verify model.pm > /dev/null && echo "$file: built"
    else
        echo "exit $? $(cat message)"
    fi
    rm -f "$file" model.pm
done
ls
