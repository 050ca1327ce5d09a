printf '%s\n' '{"eye":[0,0,5],"target":[0,0,0],"t":2}' '{"eye":[0,0,9],"target":[0,0,0],"t":2.5}' |
    qs-path spline - --timing keys --fps 4
