# What a server refuses before it listens.
source "$QS_SOURCE/tests/tools/pm-serve/server.bash"
make-ball
echo nothing > bad.pm
for words in "" "ball.pm --listen nowhere" "ball.pm --listen 127.0.0.1:0 --stdio" "bad.pm" "none.pm" "ball.pm ball=ball.pm" \
    "ball.pm --status 127.0.0.1:1" "ball.pm --packet 0" "ball.pm --listen ./ball.pm" "--status ./none"; do
    pm-serve $words
    echo "status $?"
done
