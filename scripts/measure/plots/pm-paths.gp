# size 980,380: error against bytes, by kind of model
file = folder.'/pm-paths.csv'
set datafile separator ','
set grid
set logscale x 2
set key bottom right
set format x '%.0b %BB'
set xlabel 'bytes until all frames are complete'
set ylabel 'mean PSNR, dB'
set multiplot layout 1,3
do for [path in 'orbit dolly walk'] {
    set title name.', '.path
    plot for [kind in '"progressive mesh" "points" "triangle leaves"'] file skip 1 \
        using (strcol(1) eq path && strcol(2) eq kind ? $4 : NaN):5 with linespoints pointtype 7 title kind
}
unset multiplot
