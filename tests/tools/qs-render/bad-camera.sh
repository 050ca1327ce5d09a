# Cameras that show nothing are refused with the reason.
qs-build "$QS_DATA/mesh-ascii.ply" -o model.qs
qs-render model.qs -o frame.ppm --camera-position 1,2,3 --camera-focal-point 1,2,3
echo "exit $?"
echo '{"eye":[1,2,3],"target":[1,2,3]}' > path.jsonl
qs-render model.qs -o frame.ppm --path path.jsonl
echo "exit $?"
echo '{"eye":[1,2,3],"target":[0,0,0],"fovy":180}' > path.jsonl
qs-render model.qs -o frame.ppm --path path.jsonl
echo "exit $?"
ls -A
