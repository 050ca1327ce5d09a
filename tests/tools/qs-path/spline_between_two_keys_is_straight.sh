# Digits beyond the fourth depend on the system's sine.
round() { perl -pe 's/-?\d+(\.\d+)?(e[-+]?\d+)?/abs($&) < 5e-5 ? 0 : 0 + sprintf("%.4f", $&)/ge'; }
printf '%s\n' '{"eye":[0,0,5],"target":[0,0,0]}' '{"eye":[2,0,5],"target":[2,0,0]}' | qs-path spline - --frames 3 | round
