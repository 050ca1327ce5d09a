# Two bow-ties' worth of trouble: a repeated face, a vertex of two fans, one without faces, and an edge of three faces.
cat > mesh.ply << 'END'
ply
format ascii 1.0
element vertex 9
property float x
property float y
property float z
element face 7
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
-1 0 0
0 -1 0
5 5 5
0 0 1
1 1 0
1 0 1
3 0 1 2
3 1 2 0
3 0 3 4
3 1 7 2
3 2 1 6
3 2 1 8
3 0 3 3
END
pm-build mesh.ply -o mesh.pm --report - | sed 's/,"ms".*/}/' | tr , '\n'
qs-info --verify mesh.pm
