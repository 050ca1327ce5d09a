cp "$QS_DATA/tiny.qs" .
qs-info --cut 2 tiny.qs -o - > /dev/full
