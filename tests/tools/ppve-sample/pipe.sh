# A session on pipes: a welcome, and no more; what is no message is told so, and the program ends well.
cp "$QS_DATA/mesh-ascii.ply" a.ply
: | ppve-sample a.ply | cat > welcome
echo "${PIPESTATUS[@]}"
head -c 7 welcome | od -An -tx1 | cut -c 14-
ppve-sample --write-clusters a.clusters a.ply --report -
: | ppve-sample a.clusters | cat > again
# The box, the same to the bit.
cmp <(tail -c +8 welcome | head -c 48) <(tail -c +8 again | head -c 48); echo "$?"
printf '\005\0\0\0trash' | ppve-sample a.ply | cat | grep -ac 'a message is cut off'
printf '\377\377\377\377' | ppve-sample a.ply | cat | grep -ac 'is said to have'
ppve-sample a.ply < a.ply | cat
