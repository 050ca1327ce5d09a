# The bytes in pm(5) are a model, and what is built of the square that it tells of.
cat > square.ply << 'END'
ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
0 0 0
2 0 0
2 2 0
0 2 0
3 0 1 2
3 0 2 3
END
python3 -c '
import re, sys
rows = [line[5:54] for line in open(sys.argv[1]) if re.match("[0-9a-f]{2}0  ", line)]
open("page.pm", "wb").write(bytes.fromhex("".join(rows)))' "$QS_SOURCE/man/pm.5"
qs-info --verify page.pm
pm-build square.ply -o - | cmp - page.pm
