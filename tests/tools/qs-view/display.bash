# For the cases of qs-view: a display without a screen, a viewer in it, and the hands of a user.  All are ended with the
# case.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs Xvfb xdotool
python3 -c "import Xlib" 2> /dev/null || { echo "python3-xlib is not installed"; exit 77; }

# The leak checker crashes now and then, in its own threads, when a program ends that has a driver's threads.
export ASAN_OPTIONS=${ASAN_OPTIONS-}:detect_leaks=0

# Without -noreset the server starts anew after each last window, and may find that another has taken its place.
start_display() {
    Xvfb -displayfd 3 -noreset -screen 0 640x480x24 -nolisten tcp 3> display > xvfb.log 2>&1 &
    started+=($!)
    wait_for test -s display
    export DISPLAY=:$(< display) LIBGL_ALWAYS_SOFTWARE=1
}

# Its messages are in view.err.
start_viewer() { # ARGUMENTS...
    : > view.err
    qs-view --verbose "$@" > view.out 2> view.err &
    viewer=$!
    started+=($viewer)
    wait_for xdotool search --name "^qs-view"
}

has_said() { (($(grep -c "$2" view.err) >= $1)); } # TIMES WHAT

# Until it has said so once more than it had before the hands moved.
said() { grep -c "$1" view.err; }         # WHAT
then_says() { wait_for has_said $(($1 + 1)) "$2"; } # BEFORE WHAT

# Keys one after the other; what they lead to is waited for by the case.
press_keys() { xdotool key --delay 30 "$@"; }

# Whether a picture has become complete since a source was opened for the so many'th time.
is_complete_since() { # TIMES
    awk -v times="$1" '/: opened / { ++opened; complete = 0 } /picture complete/ { complete = 1 }
        END { exit !(opened == times && complete) }' view.err
}

# Opened anew, with the camera and the colours where they are: what is complete then is of these, and not of some way
# towards them.
open_anew() {
    local opened
    opened=$(said ": opened ")
    press_keys F5
    wait_for is_complete_since $((opened + 1))
}

# What the window shows, by its colours: the legend's red and the grey of the glass's rim are nowhere else.
shows() { # R G B: whether the window, of 320 x 240 pixels, has so coloured ones
    ffmpeg -v error -y -f x11grab -video_size 320x240 -i "$DISPLAY+0,0" -frames:v 1 -f rawvideo -pix_fmt rgb24 window.rgb
    python3 -c 'import sys
data = open("window.rgb", "rb").read()
colour = bytes(map(int, sys.argv[1:]))
sys.exit(not any(data[i:i + 3] == colour for i in range(0, len(data), 3)))' "$@"
}
shows_legend() { shows 220 60 50; }
shows_glass() { shows 204 204 204; }

end_viewer() {
    wait $viewer
    echo "the viewer ends with status $?"
}
