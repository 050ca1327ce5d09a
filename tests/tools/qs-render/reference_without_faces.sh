"$QS_SOURCE/tests/tools/make-bumpy-ply" 10 cloud > cloud.ply
qs-build cloud.ply -o model.qs
qs-render model.qs --resolution 64,48 --reference cloud.ply --report -
