# Digits beyond the fourth depend on the system's sine.
round() { perl -pe 's/-?\d+(\.\d+)?(e[-+]?\d+)?/abs($&) < 5e-5 ? 0 : 0 + sprintf("%.4f", $&)/ge'; }
qs-path orbit --bounds 1,2,3,1 --elevation 0 --frames 4 --fovy 60 --distance 1 | round
