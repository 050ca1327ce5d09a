mkdir one other
echo notes > one/notes.txt
qs-compare one other
