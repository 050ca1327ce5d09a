# One client on pipes: the message "catalogue", and the answer in its frame.
source "$QS_SOURCE/tests/tools/pm-serve/server.bash"
make-ball
printf '\1\0\0\0\5' | pm-serve --stdio head=ball.pm | cat > answer
echo "frame of $((16#$(od -An -v -tx1 answer | tr -d ' \n' | sed -E 's/^(..)(..)(..)(..).*/\4\3\2\1/'))) bytes in $(wc -c < answer)"
tail -c +6 answer | sed -E 's/"hash":"[0-9a-f]{16}"/"hash":.../'
# What is no message is said to be none, and is not waited for.
printf '\1\0\0\0\115' | pm-serve --stdio ball.pm | tail -c +6
