# Every kind of source is turned, gone near to, recorded, coloured, magnified and left, as by_hand.sh does it with a model:
# the picture at the end of the recorded path is the one that qs-render draws of that path, and another one than the first.
source "$QS_SOURCE/tests/tools/qs-view/display.bash"
source "$QS_SOURCE/tests/tools/qs-view/sources.bash"
make_balls
start_display
size=(--resolution 320,240)

take_shot() { # FILE
    local before
    before=$(said "wrote")
    press_keys s
    then_says "$before" "wrote qs-view-"
    mv qs-view-0001.png "$1"
}
agree() { # PICTURE PICTURE: where points are thinned in time, what is settled is as good, but not the same
    if [[ $kind != points* ]]; then cmp "$1" "$2"; else is_more "$(psnr "$1" "$2")" 30; fi
}

drive() { # KIND DRAWN_AS... -- SOURCE...: DRAWN_AS is what qs-render draws
    kind=$1 as=()
    shift
    while [[ $1 != -- ]]; do as+=("$1") && shift; done
    shift
    rm -f path.jsonl
    xdotool mousemove 160 120
    start_viewer "$@" "${size[@]}"
    then_says 0 "picture complete"
    take_shot first.png
    press_keys r
    xdotool mousedown 1
    for ((i = 0; i < 6; ++i)); do xdotool mousemove_relative 6 2 sleep 0.02; done
    xdotool mouseup 1 key space mousemove 150 110 click 4 click 4
    press_keys Right r
    wait_for test -s qs-view-0001.jsonl
    mv qs-view-0001.jsonl path.jsonl
    open_anew
    take_shot turned.png
    draw_last
    agree turned.png last.png && echo "$kind: turned, nearer and recorded"
    is_more 25 "$(psnr turned.png first.png)" && echo "$kind: another picture than the first"

    shows_legend && echo "$kind: the legend's red is elsewhere"
    press_keys c
    wait_for shows_legend && echo "$kind: colours have a legend"
    open_anew
    take_shot coloured.png
    draw_last --shade level
    agree coloured.png last.png && echo "$kind: colours are those of qs-render"

    shows_glass && echo "$kind: the grey of the glass is elsewhere"
    xdotool mousemove 160 120 keydown m
    wait_for shows_glass && echo "$kind: magnified"
    xdotool keyup m
    press_keys q
    end_viewer
}
draw_last() { # OPTIONS...: the last camera of the path
    local last=$(($(wc -l < path.jsonl) - 1))
    qs-render "${as[@]}" --path path.jsonl --frames $last: "${size[@]}" "$@" -o drawn-%d.png
    mv drawn-$last.png last.png
}

drive "a mesh" ball.qs -- ball.ply
drive "two models" plain.qs plain.qs@0.5,0,0 -- plain.qs plain.qs@0.5,0,0
drive "a progressive mesh" ball.pm -- ball.pm
serve_mesh
drive "a progressive mesh at a server" "$served_mesh" -- "$served_mesh"
serve_points
drive "points of a server" "$served_points" -- "$served_points"
serve_model
drive "a model at a web server" plain.qs -- "$served_model" --cache cache
qs-fetch stop --cache cache
