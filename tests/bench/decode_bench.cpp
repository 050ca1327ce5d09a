// How fast the blocks of a compressed model are brought into their plain form: plain bytes a second on one
// core (processor time), index and checksum included, as the best and the median of many runs over all of its
// blocks, in JSON.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "splat/coding/coded_file.h"

namespace {

// Of this thread: other programs do not count.
double processor_seconds() {
    timespec now = {};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

double seconds_to_decode(const splat::CodedFile& file, std::span<std::byte> block, uint64_t& faults) {
    const double start = processor_seconds();
    for (uint64_t b = 0; b < file.header().block_count; ++b) {
        file.read(b, block);
        uint32_t sum;
        std::memcpy(&sum, block.data(), sizeof(sum));
        faults += sum != splat::block_checksum(block, b);
        // The rest of a shorter block is 0.
        std::fill(block.begin(), block.end(), std::byte{0});
    }
    return processor_seconds() - start;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2 || argc > 3) {
        std::fputs("usage: decode_bench MODEL [RUNS]\n", stderr);
        return 2;
    }
    try {
        const core::InputFile input(argv[1]);
        const splat::CodedFile file(input.bytes(), input.name());
        const int runs = argc > 2 ? std::max(1, std::atoi(argv[2])) : 21;
        std::vector<std::byte> block(file.header().block_size);
        std::vector<double> seconds;
        uint64_t faults = 0;
        for (int run = 0; run <= runs; ++run) {
            const double s = seconds_to_decode(file, block, faults);
            if (run > 0) seconds.push_back(s);  // the first brings the file into memory
        }
        std::sort(seconds.begin(), seconds.end());
        const double plain_bytes = double(file.header().block_count) * double(block.size());
        std::printf(
            "{\"runs\":%d,\"plain_bytes\":%.0f,\"best_bytes_per_s\":%.0f,\"median_bytes_per_s\":%.0f,"
            "\"faults\":%llu}\n",
            runs, plain_bytes, plain_bytes / seconds.front(), plain_bytes / seconds[seconds.size() / 2],
            static_cast<unsigned long long>(faults));
        return faults > 0;
    } catch (const core::Error& error) {
        std::fprintf(stderr, "decode_bench: %s\n", error.what());
        return 1;
    }
}
