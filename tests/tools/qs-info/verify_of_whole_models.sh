cp "$QS_DATA/tiny.qs" a.qs
cp "$QS_DATA/tiny.qs" b.qs
qs-info --verify a.qs b.qs
qs-info --verify --json a.qs
