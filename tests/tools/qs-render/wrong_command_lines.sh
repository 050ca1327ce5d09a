# Each is refused before anything is read or written.
try() {
    qs-render "$@" 2>&1 | head -n 1
}
try
try model.qs
try model.qs -o frame.png --resolution 0,720
try model.qs -o frame.png --resolution 1280,16385
try model.qs -o frame.png --resolution 12.5,10
try model.qs -o frame.png --threshold -1
try model.qs -o frame.png --threshold 1,5
try model.qs -o frame.png --threshold 2 --threshold-diameter 3
try model.qs -o frame.png --splat disc
try model.qs -o frame.png --shade dark
try model.qs -o frame.png --format gif
try model.qs -o frame.gif
try model.qs -o frame.png --background 1,2
try model.qs -o frame.png --background 1,2,256
try model.qs -o frame.png --background "#12345"
try model.qs -o frame.png --background "#12345g"
try model.qs -o frame-%s.png
try model.qs -o frame.y4m --fps 0
try - --path - -o frame.png
try model.qs --path path.jsonl --camera-view-angle 40 -o frame-%d.png
try model.qs -o - --depth -
try model.qs -o - --report -
try model.qs -o same --format rgb --depth same
try model.qs -o frame.png --reference mesh.ply
try model.qs --report - --reference mesh.ply --shade level
try model.qs --report - --reference -
ls -A
