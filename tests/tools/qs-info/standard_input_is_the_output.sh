# A level of the model that it would replace.
cp "$QS_DATA/tiny.qs" .
qs-info --cut 1 - -o tiny.qs < tiny.qs
echo "exit $?"
qs-info - --report tiny.qs < tiny.qs
echo "exit $?"
cmp tiny.qs "$QS_DATA/tiny.qs"
