# Digits beyond the fourth depend on the system's sine.
round() { perl -pe 's/-?\d+(\.\d+)?(e[-+]?\d+)?/abs($&) < 5e-5 ? 0 : 0 + sprintf("%.4f", $&)/ge'; }
qs-path dolly --bounds 0,0,0,1 --target 0,0,1 --elevation 0 --near-factor 0.01 --far-factor 1 --fovy 60 --frames 4 --fps 10 | round
