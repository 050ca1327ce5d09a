# size 640,400: what a server keeps of a client along a path
file = folder.'/pm-memory.csv'
set datafile separator ','
set grid
set logscale y 2
set key center right
set format y '%.0b %BB'
set title name.', walk, twice as fine from the middle on: memory of a server for a client'
set xlabel 'frame'
plot file skip 1 using 1:7 with lines title "list of the front (paper)", \
    file skip 1 using 1:6 with lines title 'window of active tags (paper)', \
    file skip 1 using 1:4 with lines title 'sent bits'
