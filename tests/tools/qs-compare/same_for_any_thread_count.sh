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
for i in 0 1 2 3 4 5; do
    picture one/$i.ppm 0112011$((i % 3))
    picture other/$i.ppm 01101110
done
for threads in 1 2 16; do qs-compare one other --json --threads $threads > $threads.json; done
cmp 1.json 2.json && cmp 1.json 16.json
