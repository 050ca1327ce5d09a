cp "$QS_DATA/tiny.qs" .
qs-info --cut 0 tiny.qs -o root.ply
sed '/end_header/q' root.ply
