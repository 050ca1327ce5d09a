# size 1100,360: bound and measured error frame by frame, at 2 px
set datafile separator ','
set grid
set logscale y 2
set key top right
set xlabel 'frame'
set multiplot layout 1,3
do for [path in 'orbit dolly walk'] {
    set title name.', '.path.', threshold 2 px'
    plot folder.'/bound.csv' skip 1 using (strcol(1) eq name && strcol(2) eq path && $3 == 2 ? $4 : NaN):5 \
             with linespoints pointtype 7 pointsize 0.4 title 'error\_bound\_px', \
         '' skip 1 using (strcol(1) eq name && strcol(2) eq path && $3 == 2 ? $4 : NaN):6 \
             with linespoints pointtype 7 pointsize 0.4 title 'measured\_error\_px'
}
unset multiplot
