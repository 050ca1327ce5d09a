# The same pyramid in many forms; its model is verified, and says what it is made of.
for mesh in "$QS_DATA"/mesh-{ascii,big-endian,little-endian,crlf-header,faces-first,strips,integers}.ply "$QS_DATA"/mesh-plain.{obj,off} "$QS_DATA"/mesh-binary.{off,stl}; do
    qs-build --quiet "$mesh" -o model.qs
    echo "$(basename "$mesh") $(qs-info --json model.qs | grep -o '"\(vertices_in\|triangles_in\|leaves\|surface\)":[^,]*' | head -n 4 | tr '\n' ' ')"
    qs-info --verify model.qs > /dev/null || exit
done
