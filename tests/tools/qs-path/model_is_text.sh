# The readers of meshes own the rest of the sentence.
echo hello > notes.txt
qs-path orbit notes.txt -o orbit.jsonl 2> said
status=$?
cut -d : -f 1,2 said
ls
exit $status
