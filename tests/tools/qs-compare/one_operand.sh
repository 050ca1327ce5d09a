qs-compare a.png
