# What ffmpeg takes a stream's colours for is what they are, and an encoded video says so.
command -v ffmpeg > found || { echo 'ffmpeg is not installed'; exit 77; }
for colour in 200,40,90 20,220,60 255,255,255 0,0,0 10,60,250; do
    draw() { qs-render "$QS_DATA/tiny.qs" --resolution 64,48 --background "$colour" --shade flat --threshold 0 "$@"; }
    draw -o a.png
    draw -o - | ffmpeg -v error -y -i - b.png
    # The silhouette's pixels share their chroma.
    ffmpeg -v error -y -i a.png -vf crop=8:8:0:0 a-corner.png
    ffmpeg -v error -y -i b.png -vf crop=8:8:0:0 b-corner.png
    qs-compare b-corner.png a-corner.png --max-difference 3 > table
done
draw -o - | ffmpeg -v error -y -i - -colorspace smpte170m video.mp4
ffprobe -v error -show_entries stream=color_range,color_space video.mp4
