# Each is refused before anything is touched.
pm-build "$QS_DATA/tiny.ply" -o model.pm
cp "$QS_DATA/tiny.ply" mesh.ply
try() {
    echo "\$ pm-build $*"
    pm-build "$@" 2>&1 | head -n 1
    echo "exit ${PIPESTATUS[0]}"
}
try mesh.ply
try mesh.ply -o mesh.ply
try mesh.ply -o out.pm --bits 3
try mesh.ply -o out.pm --bits 25
try mesh.ply -o out.pm --bits 14 --lossless
try model.pm -o out.pm
try model.pm -o out.ply --level full --bits 12
for level in '' -1 1.5 101% 5%% % nan full% 99999999999999999999; do try model.pm -o out.ply --level "$level"; done
try model.pm -o out.ply --level 4000
try mesh.ply -o out.ply --level full
try missing.ply -o out.pm
ls
