# A thousand clients are served; one that sends garbage, floods or dies is seen by no other, and nothing leaks.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs python3
make_file model.qs 100000
start_hostile www/model.qs
start_daemon
python3 "$QS_SOURCE/tests/tools/qs-fetch/raw-clients" cache/socket $daemon "http://127.0.0.1:$port/right"
fetch get "http://127.0.0.1:$port/right" -o got && same got www/model.qs "after all that"
