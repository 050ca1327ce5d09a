# A file that only begins like one of the original's, then whole ones.
printf 'QSplat11 and whatever comes then' > old.qs
cp "$QS_DATA/qsplat/fragments.qs" .
qs-info old.qs || echo "status $?"
qs-info fragments.qs
qs-info --json fragments.qs
qs-info --verify fragments.qs
qs-info --verify --json fragments.qs
