# A model is opened, turned, looked at from near by, coloured, magnified, recorded and left, as by hand; what is seen is
# what qs-render draws.
source "$QS_SOURCE/tests/tools/qs-view/display.bash"
cp "$QS_DATA/bumpy.qs" .
start_display
start_viewer bumpy.qs --resolution 320,240
then_says 0 "picture complete"
before=$(said "wrote")
press_keys s
then_says "$before" "wrote qs-view-0001.png"
qs-render bumpy.qs --resolution 320,240 -o first.png
cmp qs-view-0001.png first.png && echo "the first picture is that of qs-render"

# Recorded: a turn, let go in motion, and a step towards what is under the mouse.
press_keys r
xdotool mousemove 160 120 mousedown 1
for ((i = 0; i < 6; ++i)); do xdotool mousemove_relative 8 3 sleep 0.02; done
xdotool mouseup 1 sleep 0.2 key space mousemove 150 110 click 4 click 4
press_keys r
wait_for test -s qs-view-0001.jsonl
open_anew
press_keys s
wait_for test -s qs-view-0002.png
frames=$(wc -l < qs-view-0001.jsonl)
((frames > 5)) && echo "a path was recorded"
qs-render bumpy.qs --path qs-view-0001.jsonl --frames $((frames - 1)): --resolution 320,240 -o last-%d.png
cmp qs-view-0002.png last-$((frames - 1)).png && echo "its last picture is that of qs-render"
cmp -s qs-view-0001.png qs-view-0002.png || echo "and is another one than the first"

# What the camera was at a saved view it is again after going home.
camera() { # COMMAND... prints the camera, which standard output has one line more of
    local lines
    lines=$(wc -l < view.out)
    press_keys p
    until (($(wc -l < view.out) > lines)); do sleep 0.02; done
    tail -n 1 view.out
}
saved=$(camera)
press_keys ctrl+1 h
[[ $(camera) != "$saved" ]] && echo "home is elsewhere"
press_keys 1
[[ $(camera) == "$saved" ]] && echo "the saved view is gone back to"

shows_legend || echo "no legend yet"
press_keys c
wait_for shows_legend && echo "colours have a legend"
xdotool mousemove 160 120 keydown m
wait_for shows_glass && echo "the glass is there while M is held"
xdotool keyup m
press_keys q
end_viewer

# Another window, empty at first: a model is dropped on it, whose saved view is there still; it fills the screen and
# goes back.
start_viewer --resolution 320,240
window=$(xdotool search --name "^qs-view")
"$QS_SOURCE/tests/tools/qs-view/drop" "$window" bumpy.qs
then_says 0 "picture complete"
press_keys 1
[[ $(camera) == "$saved" ]] && echo "a view is kept for the next window"
has_size() { # WIDTH HEIGHT: of the window
    [[ $(xdotool getwindowgeometry --shell "$window") == *"WIDTH=$1"*"HEIGHT=$2"* ]]
}
press_keys F11
wait_for has_size 640 480 && echo "the window fills the screen"
press_keys F11
wait_for has_size 320 240 && echo "and goes back"
press_keys q
end_viewer
