# The format's first file, as qs(5) shows it.
qs-build "$QS_DATA/tiny.ply" -o tiny.qs
cmp tiny.qs "$QS_DATA/tiny.qs"
