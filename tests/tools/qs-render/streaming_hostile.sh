# A compressed model whose server is at fault is drawn as its file is, or is not drawn, and one line says why.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
mkdir www
"$QS_SOURCE/tests/tools/make-bumpy-ply" 60 > bumpy.ply
qs-build bumpy.ply -o www/model.qs
qs-build www/model.qs --compress -o www/coded.qs
view=(--camera-elevation-angle 30 --resolution 160,120 --quiet)
qs-render www/model.qs "${view[@]}" -o file.png
start_daemon --retries 2
start_hostile www/coded.qs
for what in right no-validator to-right small-parts short reset failing busy ignores-if-range \
    no-ranges other-range longer-range odd-range no-content-range unknown-total huge-total other-length long-unsaid \
    always-short gzip parts unsatisfiable empty always-failing loop to-file long-header missing; do
    rm -f got.png
    if qs-render "http://127.0.0.1:$port/$what" --cache cache "${view[@]}" -o got.png 2> said; then
        same file.png got.png "$what"
    else
        without_port < said
        test ! -e got.png || echo "something is drawn"
    fi
done
