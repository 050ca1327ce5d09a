# What is not covered is transparent; over the background it is what is drawn over it.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
draw="qs-render model.qs --resolution 64,48"
alphas() {
    ffmpeg -v error -i "$1" -f rawvideo -pix_fmt rgba - | od -An -v -tu1 -w4 | awk '{ print $4 }' | sort -un | tr '\n' ' '
    echo
}
$draw --background none -o one.png && alphas one.png
$draw --background none --samples 4 -o four.png && alphas four.png
$draw --background "#40506080" -o half.png && alphas half.png
# Laid over black, as qs-compare does, to within the rounding.
$draw --samples 4 -o black.png
qs-compare four.png black.png --max-difference 1 > /dev/null && echo "the same over black"
