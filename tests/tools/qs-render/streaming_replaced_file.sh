# A file that is replaced while it is drawn: the user is told, pictures stay of the version that was opened, and the next
# run draws the new one.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs nginx
mkdir www
"$QS_SOURCE/tests/tools/make-bumpy-ply" 120 > bumpy.ply
qs-build bumpy.ply -o www/model.qs
cp www/model.qs old.qs
"$QS_SOURCE/tests/tools/make-bumpy-ply" 90 > other.ply
qs-build other.ply -o other.qs
start_nginx
start_daemon --limit-rate 256k
url=http://127.0.0.1:$port/model.qs
view=(--camera-position 0,1,6 --resolution 320,240)
qs-render other.qs "${view[@]}" -o new.png
cp other.qs next.qs
qs-render "$url" --cache cache "${view[@]}" --snapshot 0s,3s -o shown-%d.png 2> err &
shown=$!
wait_for test -e shown-0.png
# Another inode, another time and another size.
mv next.qs www/model.qs
wait $shown
without_port < err
cmp -s shown-1.png new.png || echo "not the new version"
fetch stop
start_daemon
qs-render "$url" --cache cache "${view[@]}" -o next.png 2> err
same new.png next.png "next run"
