# Header fields go to the servers that they are for, and to no others.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs curl
make_file model.qs 100000
start_hostile www/model.qs
url=http://127.0.0.1:$port
cat > headers << FIELDS
# for a test
$url/let-in/ X-Word: sesame
$url/let-in/ Authorization:   Bearer 123
$url/let-in-elsewhere/ X-Word: sesame
FIELDS
qs-fetch serve --cache cache --headers headers
chmod 600 headers
start_daemon --headers headers
fetch get "$url/let-in/" -o got && same got www/model.qs "with the fields"
fetch get "$url/let-in" -o got 2>&1 | without_port
# They are not carried along to where a redirect leads.
fetch get "$url/let-in-elsewhere/" -o got 2>&1 | without_port
fetch get "$url/let-in-elsewhere" -o got && same got www/model.qs "redirected"
echo "the word was told $(curl -s "$url/count/word/sesame") times"
fetch stop
for line in "https://host Authorization: x" "ftp://host/ A: b" "https://host/ Authorization" "https://host/ A:" \
    "https://host/ Range: bytes=0-1" "https://host/ If-Range: x" "https://host/" $'https://host/ A: \x01'; do
    echo "$line" > headers
    qs-fetch serve --cache cache --headers headers
done
# The file in its place is found.
mkdir -p .config/qs-fetch && echo "$url/let-in/ X-Word sesame" > .config/qs-fetch/headers && chmod 600 .config/qs-fetch/headers
qs-fetch serve --cache cache 2>&1 | sed "s|$PWD|HOME|"
