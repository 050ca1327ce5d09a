cp "$QS_DATA/tiny.qs" .
for threads in 1 2 16; do qs-info --threads $threads --cut 2 tiny.qs -o - | md5sum; done | uniq | wc -l
