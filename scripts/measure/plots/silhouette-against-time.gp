# size 1100,400: growth of the silhouette and error of depths against time, of the first subject
set datafile separator ','
set grid
set logscale xy 2
set key top right
set xlabel 'ms a frame, median'
set multiplot layout 1,2
set title name.', fit: growth of the silhouette, parts of its area'
plot for [kind in '"square by diameter" "circle by diameter" square circle ellipse smooth'] folder.'/error-against-time.csv' skip 1 \
    using (strcol(1) eq name && strcol(3) eq kind && $19 > 0 ? $6 : NaN):19 with linespoints pointtype 7 pointsize 0.5 title kind
set title name.', fit: depth, RMSE in pixels'
plot for [kind in '"square by diameter" "circle by diameter" square circle ellipse smooth'] folder.'/error-against-time.csv' skip 1 \
    using (strcol(1) eq name && strcol(3) eq kind ? $6 : NaN):18 with linespoints pointtype 7 pointsize 0.5 title kind
unset multiplot
