# Each answer that is wrong is told in one line, and never reaches the file or the cache.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 100000
start_hostile www/model.qs
start_daemon --retries 2
for what in right no-validator to-right small-parts short reset failing busy ignores-if-range \
    no-ranges other-range longer-range odd-range no-content-range unknown-total huge-total other-length long-unsaid \
    always-short gzip parts unsatisfiable empty always-failing loop to-file long-header missing; do
    rm -f got
    if fetch get "http://127.0.0.1:$port/$what" -o got 2> said; then
        same got www/model.qs "$what"
    else
        without_port < said
        test ! -e got || echo "something is written"
    fi
done
fetch get ftp://127.0.0.1/x -o got
fetch get http:// -o got
fetch get "http://127.0.0.1:$port/a b" -o got 2>&1 | without_port
echo "status $?"
