# The corners of every face, in its sense, from the least one on: the same lines from the input and from the model.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > bumpy.ply
pm-build bumpy.ply --lossless -o model.pm
qs-info --verify model.pm
pm-build model.pm --level full -o full.ply
faces() {
    python3 - "$1" << 'END'
import struct, sys
data = open(sys.argv[1], "rb").read()
head, body = data.split(b"end_header\n", 1)
head = head.decode().split("\n")
count = {l.split()[1]: int(l.split()[2]) for l in head if l.startswith("element")}
if "format ascii 1.0" in head:
    rows = body.decode().split("\n")
    vertices = [tuple(struct.unpack("<f", struct.pack("<f", float(x)))[0] for x in r.split()[:3]) for r in rows[:count["vertex"]]]
    faces = [tuple(map(int, r.split()[1:4])) for r in rows[count["vertex"]:count["vertex"] + count["face"]]]
else:
    size = sum({"float": 4, "uchar": 1, "double": 8}[l.split()[1]] for l in head if l.startswith("property") and "list" not in l)
    vertices = [struct.unpack_from("<3f", body, size * v) for v in range(count["vertex"])]
    faces = [struct.unpack_from("<3I", body, size * count["vertex"] + 13 * f + 1) for f in range(count["face"])]
places = ([vertices[v] for v in f] for f in faces)
for face in sorted(min(p, p[1:] + p[:1], p[2:] + p[:2]) for p in places):
    print(face)
END
}
cmp <(faces bumpy.ply) <(faces full.ply)
faces full.ply | wc -l
