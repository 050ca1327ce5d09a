# A pipe by name is read once, and a model may come through one.
qs-build <(cat "$QS_DATA/tiny.ply") -o tiny.qs
cmp tiny.qs "$QS_DATA/tiny.qs"
qs-build <(cat tiny.qs) --compress -o coded.qs
qs-build - --plain -o plain.qs < coded.qs
cmp tiny.qs plain.qs
qs-build tiny.qs --leaf triangle --compress -o none.qs
