cp "$QS_DATA/tiny.qs" good.qs
head -c 100 good.qs > header-cut.qs
echo hello > text.qs
{ cat good.qs; echo; } > longer.qs
qs-info --verify header-cut.qs text.qs good.qs missing.qs longer.qs
