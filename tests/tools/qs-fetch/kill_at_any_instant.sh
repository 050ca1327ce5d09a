# A daemon that is killed during a download leaves only blocks that are right, and the next one goes on from there.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
make_file model.qs 2000001
start_hostile www/model.qs
url=http://127.0.0.1:$port/right
some_are_there() {
    python3 -c 'import glob, sys
states = b"".join(open(f, "rb").read()[4096:] for f in glob.glob("cache/*/map"))
sys.exit(not any(byte >> shift & 3 == 3 for byte in states for shift in (0, 2, 4, 6)))'
}
for ((run = 0; run < 12; ++run)); do
    start_daemon --limit-rate 8M
    fetch get "$url" -o got 2> /dev/null &
    getting=$!
    sleep "0.$((RANDOM % 3))$((RANDOM % 10))"
    # On a slow machine the others may all have ended before the first block.
    ((run < 11)) || wait_for some_are_there
    kill -9 $daemon
    wait $daemon $getting 2> /dev/null
    # Killed before it was asked: then get has started a daemon of its own.
    if [[ -e got ]]; then
        fetch stop
        rm -r got cache
        continue
    fi
    python3 - cache www/model.qs << 'CHECK'
import glob, struct, sys
file = open(sys.argv[2], "rb").read()
for folder in glob.glob(sys.argv[1] + "/" + "[0-9a-f]" * 32):
    states, data = open(folder + "/map", "rb").read()[4096:], open(folder + "/data", "rb").read()
    for block in range((len(file) + 1023) // 1024):
        if states[block // 4] >> block % 4 * 2 & 3 == 3:
            part = slice(block * 1024, block * 1024 + 1024)
            if data[part] != file[part]:
                print("block", block, "is marked present, and wrong")
CHECK
    rm -f cache/socket
done
# Of the last run something is left, unless it had all and was thrown away.
if [[ -d cache ]]; then left=some; else left=; fi
start_daemon
fetch get "$url" -o got && same got www/model.qs "in the end"
if [[ $left ]] && (($(counter body_bytes) >= 2000001)); then echo "what the last run had fetched was lost"; fi
