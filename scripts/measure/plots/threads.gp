# size 640,480: frames by threads, measured and modelled
set datafile separator ','
set grid
set logscale xy 2
set key top right
set xlabel 'threads'
set ylabel 'ms a frame'
subjects = system("cut -d, -f1 '".folder."/threads.csv' | tail -n +2 | uniq")
plot for [model in subjects] folder.'/threads.csv' skip 1 using (strcol(1) eq model ? $2 : NaN):4 \
         with linespoints pointtype 6 title model.', modelled', \
     for [model in subjects] '' skip 1 using (strcol(1) eq model ? $2 : NaN):3 \
         with points pointtype 7 pointsize 1.2 title model.', measured'
