#include "core/pages.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace {

TEST(Pages, ResizedVectorsHoldWhatVectorsDo) {
    for (const size_t count : {size_t{0}, size_t{1}, size_t{5000}, size_t{3'000'001}}) {
        std::vector<uint32_t> v(3), plain(3);
        std::iota(v.begin(), v.end(), 7u), std::iota(plain.begin(), plain.end(), 7u);
        core::resize(v, count), plain.resize(count);
        EXPECT_EQ(v, plain) << count;
    }
}

TEST(Pages, TakingThemChangesNothing) {
    std::vector<uint8_t> bytes(size_t{20} << 20);
    std::iota(bytes.begin(), bytes.end(), uint8_t{0});
    const std::vector<uint8_t> before = bytes;
    core::take_pages(bytes.data() + 1, bytes.size() - 2);
    EXPECT_EQ(bytes, before);
}

TEST(Pages, ReservedVectorsAreAsTheyWere) {
    std::vector<uint32_t> v{1, 2, 3};
    core::reserve(v, 5'000'000);
    EXPECT_GE(v.capacity(), 5'000'000u);
    EXPECT_EQ(v, (std::vector<uint32_t>{1, 2, 3}));
}

}  // namespace
