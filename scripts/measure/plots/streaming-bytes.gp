# size 760,560: what is seen while a model arrives, by bytes
file = folder.'/streaming.csv'
set datafile separator ','
set grid
set logscale x 2
set key top left
set format x '%.0b %BB'
set xlabel 'bytes fetched'
set ylabel 'PSNR, dB'
set yrange [10:50]
# That on which all orders were looked at.
link = system("tail -n +2 '".file."' | cut -d, -f1,2 | sort -u | cut -d, -f1 | uniq -c | sort -rn | sed -n '1s/^ *[0-9]* //p'")
set title name.', fit, smooth, '.link.': PSNR against the whole model, by bytes'
plot for [order in 'gain level radius screen y sweep'] file skip 1 \
    using (strcol(1) eq link && strcol(2) eq order ? $4 : NaN):5 with linespoints pointtype 7 pointsize 0.5 title order, \
    file skip 1 using (strcol(1) eq link && strcol(2) eq 'gain of the compressed model' ? $4 : NaN):5 \
    with linespoints pointtype 7 pointsize 0.5 linecolor rgb 'red' title 'gain, compressed', \
    file skip 1 using (strcol(1) eq link && strcol(2) eq 'the file from its beginning' ? $4 : NaN):5 \
    with lines dashtype 2 linecolor rgb 'gray40' title 'file from its beginning'
