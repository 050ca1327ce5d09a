#include "ppve/sample/depth_pyramid.h"

#include <algorithm>

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ppve/sample/depth_pyramid.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ppve::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The least of `rows` rows of `columns` words each, which begin `stride` words apart.
uint64_t LeastOf(const uint64_t* words, size_t columns, size_t rows, size_t stride) {
    const hn::ScalableTag<uint64_t> d;
    const size_t lanes = hn::Lanes(d), whole = columns - columns % lanes;
    auto least = hn::Set(d, ~uint64_t(0));
    uint64_t rest = ~uint64_t(0);
    for (size_t y = 0; y < rows; ++y, words += stride) {
        for (size_t x = 0; x < whole; x += lanes) least = hn::Min(least, hn::LoadU(d, words + x));
        for (size_t x = whole; x < columns; ++x) rest = std::min(rest, words[x]);
    }
    return std::min(rest, hn::GetLane(hn::MinOfLanes(d, least)));
}

}  // namespace ppve::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ppve {

HWY_EXPORT(LeastOf);

namespace {

constexpr int kBlock = 16;  // pixels a side: 0.2 ms for a million pixels, and clusters are seldom smaller

}  // namespace

void DepthPyramid::clear(int width, int height) {
    width_ = width, height_ = height;
    across_ = (width + kBlock - 1) / kBlock, down_ = (height + kBlock - 1) / kBlock;
    farthest_.assign(size_t(across_) * size_t(down_), 0);
}

void DepthPyramid::update(std::span<const uint64_t> words) {
    core::parallel_for(size_t(down_), [&](size_t row) {
        const size_t first = row * kBlock, rows = std::min<size_t>(kBlock, size_t(height_) - first);
        for (size_t block = 0; block < size_t(across_); ++block) {
            const size_t left = block * kBlock, columns = std::min<size_t>(kBlock, size_t(width_) - left);
            farthest_[row * size_t(across_) + block] = HWY_DYNAMIC_DISPATCH(LeastOf)(
                &words[first * size_t(width_) + left], columns, rows, size_t(width_));
        }
    });
}

bool DepthPyramid::hides(const render::PixelBox& box, uint64_t nearest) const {
    for (int y = box.first_y / kBlock; y <= box.last_y / kBlock; ++y)
        for (int x = box.first_x / kBlock; x <= box.last_x / kBlock; ++x)
            if (farthest_[size_t(y) * size_t(across_) + size_t(x)] <= nearest) return false;
    return true;
}

}  // namespace ppve
#endif
