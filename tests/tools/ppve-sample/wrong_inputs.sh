# What cannot be sampled is said in a line, and ends with 1 or 2.
try() { ppve-sample "$@" < /dev/null > out; echo "$?"; }
try missing.ply
printf 'text' > text.txt
try text.txt
printf 'ppveclus short' > short.clusters
try short.clusters
printf 'NDims = 3\nElementType = MET_SHORT\nDimSize = 4 4 4\nElementDataFile = ../v.raw\n' > v.mhd
try v.mhd
cp "$QS_DATA/mesh-ascii.ply" a.ply
try --sampler magic a.ply
try --listen nowhere a.ply
try --listen :0 --write-clusters x a.ply
