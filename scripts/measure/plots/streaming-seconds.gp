# size 1200,950: what is seen while a model arrives, by seconds
file = folder.'/streaming.csv'
set datafile separator ','
set grid
set logscale x 10
set format x '%g'
set xlabel 'seconds since the start' offset 0,0.5
set ylabel 'PSNR, dB' offset 1,0
set xrange [0.05:]
set yrange [10:50]
links = system("tail -n +2 '".file."' | cut -d, -f1 | awk '!seen[$0]++ { print \"\\\"\" $0 \"\\\"\" }' | tr '\\n' ' '")
orders = 'gain level radius screen y sweep'
set multiplot layout (words(links) + 2) / 3, 3 title name.', fit, smooth: PSNR against the whole model, by seconds'
do for [i=1:words(links)] {
    link = word(links, i)
    set title link
    # Once is enough; the first link is the slowest, and has room.
    if (i == 1) { set key top left font ",9" samplen 2 } else { set key off }
    plot for [order in orders] file skip 1 using (strcol(1) eq link && strcol(2) eq order ? $3 : NaN):5 \
        with linespoints pointtype 7 pointsize 0.4 title order, \
        file skip 1 using (strcol(1) eq link && strcol(2) eq 'gain of the compressed model' ? $3 : NaN):5 \
        with linespoints pointtype 7 pointsize 0.4 linecolor rgb 'red' title 'gain, compressed', \
        file skip 1 using (strcol(1) eq link && strcol(2) eq 'the file from its beginning' ? $3 : NaN):5 \
        with lines dashtype 2 linecolor rgb 'gray40' title 'file from its beginning', \
        file skip 1 using (strcol(1) eq link && strcol(2) eq 'the whole file by curl' ? $3 : NaN):(48) \
        with points pointtype 9 linecolor rgb 'black' title 'whole file by curl'
}
unset multiplot
