# size 1000,400: a frame of one quality against the size of the model
set datafile separator ','
set grid
set logscale xy
unset key
set xlabel 'vertices'
set multiplot layout 1,2
set title 'A frame of the same PSNR: ms'
set yrange [*<1:10<*]
plot folder.'/size.csv' skip 1 using 2:7 with linespoints pointtype 7
set title 'Bytes: of the file, and touched by the frame'
set key top left
set yrange [*:*]
plot folder.'/size.csv' skip 1 using 2:3 with linespoints pointtype 7 title 'file', \
     '' skip 1 using 2:11 with linespoints pointtype 7 title 'touched'
unset multiplot
