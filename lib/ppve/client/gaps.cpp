#include "ppve/client/gaps.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace ppve {

namespace {

constexpr double kMostRise = 10;  // footprints a pixel; 4 is as good

float depth_of(uint64_t word) {
    return std::bit_cast<float>(static_cast<uint32_t>(word >> 32));
}

// Of depths and colours.
uint64_t mean_of(uint64_t a, uint64_t b) {
    const float depth = 0.5f * (depth_of(a) + depth_of(b));
    // Four channels at once: half of the sum is what they share and half of where they differ.
    const auto x = static_cast<uint32_t>(a), y = static_cast<uint32_t>(b);
    const uint32_t colour = (x & y) + ((x ^ y) >> 1 & 0x7f7f7f7fu);
    return uint64_t(std::bit_cast<uint32_t>(depth)) << 32 | colour;
}

}  // namespace

GapCloser::GapCloser(const PointRaster& raster, double focal_px)
    : raster_(raster), rise_(static_cast<float>(1 + kMostRise / focal_px)) {
    const size_t width = size_t(raster.width());
    for (auto* depths : {&above_, &here_, &below_})
        depths->resize(width + 2, std::numeric_limits<float>::infinity());
    nearest_.resize(width), words_.resize(width);
}

void GapCloser::load(int y, std::vector<float>& depths) const {
    const size_t width = size_t(raster_.width());
    if (y < 0 || y >= raster_.height()) {
        std::fill(depths.begin(), depths.end(), std::numeric_limits<float>::infinity());
        return;
    }
    const uint64_t* const words = raster_.row(y);
    for (size_t x = 0; x < width; ++x) depths[x + 1] = depth_of(words[x]);
}

uint64_t GapCloser::closed(int x, int y, float depth) const {
    constexpr int kPairs[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
    for (const auto& [dx, dy] : kPairs) {
        const bool is_beside = dx != 0 && (x < 1 || x + 1 >= raster_.width());
        if (is_beside || (dy != 0 && (y < 1 || y + 1 >= raster_.height()))) continue;
        const uint64_t a = raster_.row(y - dy)[x - dx], b = raster_.row(y + dy)[x + dx];
        if (std::max(depth_of(a), depth_of(b)) == depth) return mean_of(a, b);
    }
    return raster_.row(y)[x];
}

const uint64_t* GapCloser::row(int y) {
    if (loaded_ + 1 == y) {
        std::swap(above_, here_), std::swap(here_, below_);
    } else {
        load(y - 1, above_), load(y, here_);
    }
    load(y + 1, below_);
    loaded_ = y;
    const size_t width = words_.size();
    for (size_t x = 0; x < width; ++x) {
        const float level = std::max(here_[x], here_[x + 2]),
                    upright = std::max(above_[x + 1], below_[x + 1]);
        const float falling = std::max(above_[x], below_[x + 2]), rising = std::max(above_[x + 2], below_[x]);
        nearest_[x] = std::min(std::min(level, upright), std::min(falling, rising));
    }
    std::copy_n(raster_.row(y), width, words_.begin());
    for (size_t x = 0; x < width; ++x)
        if (nearest_[x] * rise_ < here_[x + 1]) words_[x] = closed(int(x), y, nearest_[x]);
    return words_.data();
}

}  // namespace ppve
