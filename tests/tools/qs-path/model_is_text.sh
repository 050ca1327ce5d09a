echo hello > notes.txt
qs-path orbit notes.txt -o orbit.jsonl
status=$?
ls
exit $status
