# A batch builds what is new, skips what is done, goes on after a kill, and says nothing but what fails.
PATH=$QS_SOURCE/examples:$PATH
mkdir scans
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > scans/a.ply
"$QS_SOURCE/tests/tools/make-bumpy-ply" 10 cloud > scans/b.PLY
batch.sh scans models && ls models
touch -d '1 hour ago' scans/* && touch -d '1 minute ago' models/*.qs
stat -c %Y models/*.qs > before
# What a run that was killed outright leaves: half a model, and a scan that is not done.
touch models/.qs-1-2-3.tmp
echo nonsense > scans/c.ply
"$QS_SOURCE/tests/tools/make-bumpy-ply" 10 > scans/d.ply
batch.sh scans models
echo "exit $?"
ls -A models
stat -c %Y models/[ab].qs | cmp - before && echo "what was done is as it was"
# One at a time.
flock models/.batch.lock batch.sh scans models && echo "a second run leaves it to the first"
