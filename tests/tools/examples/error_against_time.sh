# The table has a row a threshold, with the error beside the time.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 12 > scan.ply
qs-build scan.ply -o scan.qs
"$QS_SOURCE/examples/error-against-time.sh" scan.qs scan.ply 1 2> warnings | awk '{ print $1, NF }'
