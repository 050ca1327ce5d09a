#include "core/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>
#include <vector>

#include "core/error.h"

namespace {

class WithThreads : public testing::TestWithParam<int> {
  protected:
    WithThreads() { core::set_thread_count(GetParam()); }
    ~WithThreads() override { core::set_thread_count(0); }
};

TEST_P(WithThreads, ForCallsEachIndexOnce) {
    for (const size_t count : {size_t{0}, size_t{1}, size_t{7}, size_t{100000}}) {
        for (const size_t grain : {size_t{1}, size_t{64}}) {
            std::vector<std::atomic<int>> calls(count);
            core::parallel_for(
                count, [&](size_t i) { ++calls[i]; }, grain);
            EXPECT_TRUE(std::all_of(calls.begin(), calls.end(), [](const auto& c) { return c == 1; }));
        }
    }
}

TEST_P(WithThreads, PiecesCoverTheRangeWithoutOverlap) {
    for (const size_t count : {0u, 1u, 9u, 10u, 11u, 12345u}) {
        std::vector<std::atomic<int>> calls(count);
        core::parallel_pieces(count, 10, [&](size_t begin, size_t end) {
            EXPECT_EQ(begin % 10, 0u);
            EXPECT_TRUE(end - begin == 10 || end == count);
            for (size_t i = begin; i < end; ++i) ++calls[i];
        });
        EXPECT_TRUE(std::all_of(calls.begin(), calls.end(), [](const auto& c) { return c == 1; }));
    }
}

// Sums by pieces round in the same places whoever adds them.
TEST_P(WithThreads, SumsByPiecesAreBitwiseEqualToOneThread) {
    const size_t count = 100003, piece = 1000;
    const auto sum = [&] {
        std::vector<double> partial((count + piece - 1) / piece);
        core::parallel_pieces(count, piece, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) partial[begin / piece] += std::sin(static_cast<double>(i));
        });
        return std::accumulate(partial.begin(), partial.end(), 0.0);
    };
    const double here = sum();
    core::set_thread_count(1);
    EXPECT_EQ(here, sum());
}

TEST_P(WithThreads, AnExceptionOfTheBodyArrives) {
    try {
        core::parallel_for(1000, [](size_t i) {
            if (i == 500) throw core::Error("face 500: is bad");
        });
        FAIL() << "nothing was thrown";
    } catch (const core::Error& error) {
        EXPECT_STREQ(error.what(), "face 500: is bad");
    }
}

TEST_P(WithThreads, LoopsNest) {
    std::atomic<size_t> calls{0};
    core::parallel_for(20, [&](size_t) { core::parallel_for(50, [&](size_t) { ++calls; }); });
    EXPECT_EQ(calls, 1000u);
}

INSTANTIATE_TEST_SUITE_P(Parallel, WithThreads, testing::Values(0, 1, 2, 16));

// Each body waits until all threads have come, so fewer threads would never finish.
TEST(Parallel, RunsAsManyThreadsAsWereAsked) {
    const int count = 8;
    core::set_thread_count(count);
    EXPECT_EQ(core::thread_count(), count);
    std::mutex mutex;
    std::condition_variable all_here;
    std::set<std::thread::id> here;
    core::parallel_for(count, [&](size_t) {
        std::unique_lock lock(mutex);
        here.insert(std::this_thread::get_id());
        all_here.notify_all();
        all_here.wait_for(lock, std::chrono::seconds(20), [&] { return here.size() == count; });
    });
    EXPECT_EQ(here.size(), static_cast<size_t>(count));
    core::set_thread_count(0);
}

TEST(Parallel, OneThreadIsTheCaller) {
    core::set_thread_count(1);
    std::set<std::thread::id> seen;
    core::parallel_for(1000, [&](size_t) { seen.insert(std::this_thread::get_id()); });
    EXPECT_EQ(seen, std::set{std::this_thread::get_id()});
    core::set_thread_count(0);
}

}  // namespace
