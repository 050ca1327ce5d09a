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
for i in 0 1; do picture one/frame-000$i.ppm 01100110; done
cp one/* other
printf 'P6\n4 2\n255\nabc' > one/frame-0000.ppm
qs-compare one other
