# size 960,400: time and memory of building against the size of the mesh
set datafile separator ','
set grid
set logscale xy
unset key
set xlabel 'vertices'
is_size(n) = n eq name || n eq name.'-x4' || n eq name.'-x16'
set multiplot layout 1,2
set title 'Building: wall time, s'
plot folder.'/build.csv' skip 1 using (is_size(strcol(1)) ? $2 : NaN):4 with linespoints pointtype 7
set title 'Building: peak memory, bytes'
plot folder.'/build.csv' skip 1 using (is_size(strcol(1)) ? $2 : NaN):9 with linespoints pointtype 7
unset multiplot
