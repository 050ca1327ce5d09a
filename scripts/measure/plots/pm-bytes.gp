# size 640,400: bytes of a walk that is made twice
file = folder.'/pm-session.csv'
set datafile separator ','
set grid
set key center right
set format y '%.0b %BB'
set title name.', walk, twice: bytes since the beginning'
set xlabel 'frame'
plot file skip 1 using 1:3 with linespoints pointtype 7 pointsize 0.5 title 'down', \
    file skip 1 using 1:2 with linespoints pointtype 7 pointsize 0.5 title 'up'
