# size 1100,720: error and empty pixels against time, while updates arrive 1, 4 and 8 times a second
set datafile separator ','
set grid
set key bottom right
set xlabel 'seconds'
set multiplot layout 2,2
do for [path in 'orbit walk'] {
    set title name.', '.path.', 18 degrees a second: PSNR, dB'
    plot for [rate in '1 4 8'] folder.'/point-curves.csv' skip 1 \
        using (strcol(1) eq path && strcol(2) eq rate && $3 == 1 && strcol(4) eq 'True' ? $5 : NaN):6 \
        with linespoints pointtype 7 pointsize 0.4 title rate.' updates/s'
    set title name.', '.path.': empty pixels, %'
    plot for [rate in '1 4 8'] folder.'/point-curves.csv' skip 1 \
        using (strcol(1) eq path && strcol(2) eq rate && $3 == 1 && strcol(4) eq 'True' ? $5 : NaN):(100 * $7) \
        with linespoints pointtype 7 pointsize 0.4 title rate.' updates/s'
}
unset multiplot
