# size 640,400: faces and times of a walk
file = folder.'/pm-session.csv'
set datafile separator ','
set grid
set key top right
set title name.', walk, twice: faces that are shown, and times'
set xlabel 'frame'
set ylabel 'faces'
set y2label 'ms'
set ytics nomirror
set y2tics
plot file skip 1 using 1:5 with lines title 'faces', \
    file skip 1 using 1:6 axes x1y2 with lines title 'refining', \
    file skip 1 using 1:7 axes x1y2 with lines title 'drawing'
