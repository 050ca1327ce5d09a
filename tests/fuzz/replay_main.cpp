// Replays a fuzz target without libFuzzer: every file of a folder as it is, then a bounded number
// of mutations of each, the same in every run.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

using Bytes = std::vector<uint8_t>;

constexpr int kMutations = 300;  // of each file: seconds for a corpus, with sanitizers too

Bytes read_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// A copy of exactly the right size, so that reading past its end shows under a sanitizer.
void run(const Bytes& bytes) {
    const Bytes exact(bytes.begin(), bytes.end());
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

// Flips bits, sets bytes to values that parsers trip over, or cuts the end off.  The distribution
// classes of <random> differ between libraries; the engine does not.
Bytes mutated(Bytes bytes, std::mt19937_64& random) {
    constexpr uint8_t kEvil[] = {0x00, 0x7f, 0x80, 0xff, '-', '9', ' ', '\n'};
    if (random() % 4 == 0) bytes.resize(random() % (bytes.size() + 1));
    for (uint64_t n = random() % 4; n > 0 && !bytes.empty(); --n) {
        // Half of the changes go to the front: headers are read there.
        const size_t reach = random() % 2 == 0 ? std::min<size_t>(bytes.size(), 256) : bytes.size();
        uint8_t& byte = bytes[random() % reach];
        if (random() % 2 == 0)
            byte = static_cast<uint8_t>(byte ^ (1u << random() % 8));
        else
            byte = kEvil[random() % std::size(kEvil)];
    }
    return bytes;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: replay CORPUS_FOLDER\n", stderr);
        return 2;
    }
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(argv[1])) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    if (paths.empty()) {
        std::fprintf(stderr, "replay: %s: the corpus is empty\n", argv[1]);
        return 1;
    }
    run({});
    for (const std::filesystem::path& path : paths) {
        const Bytes seed = read_file(path);
        run(seed);
        std::mt19937_64 random(1);
        for (int n = 0; n < kMutations; ++n) run(mutated(seed, random));
    }
    std::printf("%zu files, %d mutations of each\n", paths.size(), kMutations);
}
