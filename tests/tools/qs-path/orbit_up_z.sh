# Digits beyond the fourth depend on the system's sine.
round() { perl -pe 's/-?\d+(\.\d+)?(e[-+]?\d+)?/abs($&) < 5e-5 ? 0 : 0 + sprintf("%.4f", $&)/ge'; }
qs-path orbit --bounds 0,0,0,1 --up z --elevation 90 --azimuth 90 --frames 2 --turns -1 --resolution 100,200 | round
