. "$QS_SOURCE/tests/tools/picture"
mkdir one other
for i in 0 1 2 3 4 5; do
    picture one/$i.ppm 0112011$((i % 3))
    picture other/$i.ppm 01101110
done
for threads in 1 2 16; do qs-compare one other --json --threads $threads > $threads.json; done
cmp 1.json 2.json && cmp 1.json 16.json
