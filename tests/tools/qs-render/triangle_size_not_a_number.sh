qs-render "$QS_DATA/tiny-triangles.qs" --triangle-size -1 -o tiny.png
