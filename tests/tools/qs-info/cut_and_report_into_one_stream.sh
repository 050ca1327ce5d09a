cp "$QS_DATA/tiny.qs" .
qs-info --cut 1 tiny.qs --report -
