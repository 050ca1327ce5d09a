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
mkdir one other
picture one/frame-0000.ppm 01100110
picture one/frame-0001.ppm 01100120
picture one/frame-0002.ppm 01130110
for i in 0 1 2; do picture other/frame-000$i.ppm 01100110; done
echo notes > one/notes.txt
qs-compare one other --max-holes 0 --min-psnr 20 --difference differences
echo "status $?"
ls differences
qs-compare differences/frame-0000.ppm.png differences/frame-0000.ppm.png > /dev/null
