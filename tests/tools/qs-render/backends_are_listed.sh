# The four names, with something about each; no model is needed.  The CPU is there, and so is what auto takes.
qs-render --list-backends > list
awk '{ print $1, (NF > 2 ? "is told about" : "is not told about") }' list
taken=$(sed -n 's/^auto *takes \([a-z]*\): .*/\1/p' list)
grep "^$taken " list | grep -c 'not there'
qs-render "$QS_DATA/tiny.qs" --resolution 8,6 --report - | grep -o '"backend":"[a-z]*"' | grep -c "\"$taken\""
qs-render --backend gl "$QS_DATA/tiny.qs" -o x.png
