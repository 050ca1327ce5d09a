# size 640,480: what the first bytes of a model draw
set datafile separator ','
set grid
set logscale x 2
unset key
set title name.', fit: PSNR of what the first bytes draw, dB'
set xlabel 'bytes'
plot folder.'/prefixes.csv' skip 1 using (strcol(1) eq name ? $2 : NaN):4 with linespoints pointtype 7
