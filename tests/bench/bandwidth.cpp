// bandwidth [MIB [RUNS]]: the yardstick of the benchmarks, how fast this machine moves memory.  Arrays of MIB
// MiB each (256) are read and copied by 1, 2, 4, ... threads up to one per processor, each thread its own
// part.  Prints one JSON line a case: bytes a second, the median and the best of RUNS (11) after one to warm
// up.  A copied byte counts once, though it is read and written.
//
// McCalpin.  Memory bandwidth and machine balance in current high performance computers.  1995.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bandwidth.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace bench::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// `count`: a multiple of 8 vectors of any length.
uint64_t Sum(const uint64_t* values, size_t count) {
    const hn::ScalableTag<uint64_t> d;
    const size_t lanes = hn::Lanes(d);
    auto a = hn::Zero(d), b = a, c = a, e = a;
    for (size_t i = 0; i < count; i += 4 * lanes) {
        a = hn::Add(a, hn::LoadU(d, values + i));
        b = hn::Add(b, hn::LoadU(d, values + i + lanes));
        c = hn::Add(c, hn::LoadU(d, values + i + 2 * lanes));
        e = hn::Add(e, hn::LoadU(d, values + i + 3 * lanes));
    }
    return hn::GetLane(hn::SumOfLanes(d, hn::Add(hn::Add(a, b), hn::Add(c, e))));
}

}  // namespace bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bench {
HWY_EXPORT(Sum);

namespace {

constexpr size_t kPart = 4096;  // values: parts begin at multiples of it

struct Arrays {
    size_t count;
    std::unique_ptr<uint64_t[]> from, to;
    std::vector<uint64_t> sums;  // so that nothing that was read is unused
};

// `work(begin, end, thread)` on each thread's part.
void on_threads(size_t count, size_t threads, const std::function<void(size_t, size_t, size_t)>& work) {
    core::parallel_for(threads, [&](size_t t) {
        const size_t parts = count / kPart;
        work(parts * t / threads * kPart, parts * (t + 1) / threads * kPart, t);
    });
}

void measure(const char* name, Arrays& arrays, size_t threads, int runs,
             const std::function<void(size_t, size_t, size_t)>& work) {
    std::vector<double> rates;
    for (int run = 0; run <= runs; ++run) {
        const auto start = std::chrono::steady_clock::now();
        on_threads(arrays.count, threads, work);
        const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (run > 0) rates.push_back(8 * double(arrays.count) / s);
    }
    std::sort(rates.begin(), rates.end());
    std::printf("{\"what\":\"%s\",\"threads\":%zu,\"median_bytes_per_s\":%.4g,\"best_bytes_per_s\":%.4g}\n",
                name, threads, rates[rates.size() / 2], rates.back());
}

}  // namespace
}  // namespace bench

int main(int argc, char** argv) {
    const long mib = argc > 1 ? std::atol(argv[1]) : 256;
    const int runs = argc > 2 ? std::atoi(argv[2]) : 11;
    if (mib < 1 || mib > 65536 || runs < 1) {
        std::fputs("usage: bandwidth [MIB [RUNS]]\n", stderr);
        return 2;
    }
    const size_t count = size_t(mib) << 17;
    const auto all_threads = size_t(core::thread_count());
    bench::Arrays arrays{count, std::make_unique<uint64_t[]>(count), std::make_unique<uint64_t[]>(count),
                         std::vector<uint64_t>(all_threads)};
    // Untouched pages would all be the one page of zeros.
    for (size_t i = 0; i < count; ++i) arrays.from[i] = i, arrays.to[i] = ~i;
    for (size_t threads = 1;; threads = std::min(2 * threads, all_threads)) {
        bench::measure("read", arrays, threads, runs, [&](size_t begin, size_t end, size_t t) {
            arrays.sums[t] = HWY_DYNAMIC_DISPATCH(bench::Sum)(&arrays.from[begin], end - begin);
        });
        bench::measure("copy", arrays, threads, runs, [&](size_t begin, size_t end, size_t) {
            std::memcpy(&arrays.to[begin], &arrays.from[begin], 8 * (end - begin));
        });
        if (threads == all_threads) break;
    }
    // Keeps the sums alive.
    return arrays.sums[0] == 1;
}
#endif
