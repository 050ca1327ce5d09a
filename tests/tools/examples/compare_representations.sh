# Every representation of a mesh draws it, and says what it costs.
"$QS_SOURCE/tests/tools/make-bumpy-ply" 20 > scan.ply
"$QS_SOURCE/examples/compare-representations.sh" scan.ply 2 |
    awk 'NR > 1 { print $1, ($2 > 1000 ? "bytes" : "no bytes"), ($3 > 20 ? "drawn" : "not drawn: " $3), NF }'
