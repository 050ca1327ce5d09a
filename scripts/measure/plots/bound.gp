# size 640,480: error bounds against what was measured, a dot a frame
set datafile separator ','
set grid
set logscale xy 2
set key bottom right
set title 'Error of a frame: bound and measured maximum'
set xlabel 'measured\_error\_px'
set ylabel 'error\_bound\_px'
set xrange [0.1:*]
plot for [path in 'orbit dolly walk'] folder.'/bound.csv' skip 1 using (strcol(2) eq path ? $6 : NaN):5 \
         with points pointtype 7 pointsize 0.5 title path, \
     x with lines linecolor 'black' title 'equal', 2 * x with lines linecolor 'black' dashtype 2 title 'twice'
