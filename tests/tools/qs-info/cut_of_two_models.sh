qs-info --cut 1 a.qs b.qs
