# size 1100,475 for two names: what a picture's error costs, PSNR
set datafile separator ','
set grid
set logscale x 2
set key outside below center maxrows 3 font ",10"
set xlabel 'ms a frame, median'
set ylabel 'PSNR, dB'
kinds = '"square by diameter" "circle by diameter" square circle ellipse smooth '. \
    system("grep -oE ',(ellipse|smooth) by (osmesa|egl),' '".folder."/error-against-time.csv' | uniq | sort -u | tr '\\n,' ' \"'")
# OpenGL has the colour of its kind, dashed.
colour(kind) = strstrt(kind, 'by diameter') ? (strstrt(kind, 'square') ? 1 : 2) : kind eq 'square' ? 3 : kind eq 'circle' ? 4 : \
    strstrt(kind, 'ellipse') ? 7 : 6
dash(kind) = strstrt(kind, 'osmesa') || strstrt(kind, 'egl') ? 2 : 1
subjects = system("cut -d, -f1 '".folder."/error-against-time.csv' | tail -n +2 | uniq")
set multiplot layout (words(subjects) + 1) / 2, 2
do for [model in subjects] {
    set title model.', fit, thresholds of 16 to 0.25 px'
    plot for [kind in kinds] folder.'/error-against-time.csv' skip 1 \
        using (strcol(1) eq model && strcol(3) eq kind ? $6 : NaN):15 \
        with linespoints linecolor colour(kind) dashtype dash(kind) pointtype 7 pointsize 0.5 title kind
}
unset multiplot
