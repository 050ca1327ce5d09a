# Neither what is no model nor what follows one is read to its end, which may never come.
{ head -c 32M /dev/zero && echo "all was read" >&2; } | qs-info -
echo "exit $?"
{ cat "$QS_DATA/tiny.qs" && head -c 32M /dev/zero && echo "all was read" >&2; } | qs-info - 2>&1 |
    sed 's/[0-9]* bytes/N bytes/'
