# Models of the original QSplat program are clouds with normals and radii of their own.
cp "$QS_DATA/qsplat/fragments.qs" "$QS_DATA/qsplat/two-levels.qs" .
qs-build fragments.qs -o new.qs --report report.json
python3 -c 'import json; r = json.load(open("report.json")); print(r["format"], r["vertices_in"], r["leaves"])'
qs-info --verify new.qs
qs-build - -o piped.qs < fragments.qs && cmp new.qs piped.qs
head -c 59 two-levels.qs > short.qs
qs-build short.qs -o short-new.qs
