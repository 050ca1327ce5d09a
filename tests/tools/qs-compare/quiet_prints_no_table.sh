. "$QS_SOURCE/tests/tools/picture"
picture one.ppm 01100110
picture other.ppm 01100111
qs-compare one.ppm other.ppm --quiet
echo "status $?"
qs-compare one.ppm other.ppm --quiet --max-holes 0
echo "status $?"
qs-compare one.ppm other.ppm --quiet --json | grep -o '"holes": [0-9]*'
