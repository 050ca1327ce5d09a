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
try model.qs -o frame.png --budget 0
try model.qs -o frame.png --budget nan
try model.qs -o frame.png --budget 33mm
try model.qs -o frame.png --budget -1ms
try model.qs -o frame.png --budget 2h
try model.qs -o frame.png --threshold nan
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
try model.qs -o frame.png --resolution 40000,720 --tile 0,0/4,4
try model.qs -o frame.png --resolution 32768,32768 --tile 0,0/2,1
try model.qs -o frame.png --tile 2,0/2,2
try model.qs -o frame.png --tile 0,0/2
try model.qs -o frame.png --tile 0,0/2,2,
try model.qs -o frame.png --resolution 3,3 --tile 0,0/4,1
try model.qs -o frame.png --frames 0:1
try model.qs -o frame-%d.png --path path.jsonl --frames 3:3
try model.qs -o frame-%d.png --path path.jsonl --frames 3
try model.qs -o frame-%d.png --path path.jsonl --frames=-1:
try model.qs -o frame-%d.png --path path.jsonl --frames ::0
try model.qs -o frame.png --samples 8
try model.qs -o frame.png --samples 16 --resolution 32768,100 --tile 0,0/2,1
try model.qs -o frame.png --samples 4 --backend osmesa
try model.qs -o frame.png --key-light 0,0,0
try model.qs -o frame.ppm --background none
try model.qs -o frame.png --background "#1234567"
try model.qs -o frame.png --eye-angle 3
try model.qs -o frame.png --stereo --tile 0,0/2,2
try model.qs -o frame-%s-%s.png --stereo
ls -A
