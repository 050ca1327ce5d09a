qs-info --cut 1.5 a.qs
