qs-path spline /dev/null
