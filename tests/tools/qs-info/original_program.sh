printf 'QSplat11 and whatever comes then' > old.qs
qs-info old.qs
