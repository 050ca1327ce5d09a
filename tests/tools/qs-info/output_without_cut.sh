qs-info a.qs -o b.ply
