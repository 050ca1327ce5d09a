cp "$QS_DATA/tiny.qs" .
for level in 0 1 2; do qs-info --cut $level tiny.qs -o - | grep -a '^element'; done
qs-info --cut 2 tiny.qs -o - | qs-build - -o again.qs
qs-info again.qs | grep -e leaves -e surface
