# A picture of 4 x 2 pixels, each of which is one letter: 0 black, 1 grey, 2 light grey, 3 red.
picture() { # NAME LETTERS
    printf 'P6\n4 2\n255\n' > "$1"
    local i
    for ((i = 0; i < 8; ++i)); do
        case ${2:i:1} in
            0) printf '\0\0\0' ;;
            1) printf 'ddd' ;;
            2) printf 'nnn' ;;
            3) printf 'ddn' ;;
        esac
    done >> "$1"
}
picture a.ppm 01100110
qs-compare a.ppm a.ppm --min-psnr 100 --min-ssim 1 --min-iou 1 --max-growth 0 --max-holes 0 --max-difference 0
