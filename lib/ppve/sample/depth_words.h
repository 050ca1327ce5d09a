// The buffer that all threads of a rasteriser draw into: a 64-bit word a pixel, 40 bits of depth above 24 of
// colour.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ppve/depth_image.h"

namespace ppve {

// Depths as codes with eight more bits than the image's, so that surfaces close together are told apart
// before they are rounded.
class DepthKeys {
  public:
    static constexpr int kBits = 40;

    // Of depths times `scale`, a power of two.
    DepthKeys(const DepthCoding& coding, double scale) {
        if (coding.projection == Projection::perspective) {
            extra_ = std::min(8, 52 - coding.bits);
            shift_ = 52 - coding.bits - extra_;
            base_ = (coding.base << extra_) - (int64_t(std::ilogb(scale)) << (coding.bits + extra_));
        } else {
            extra_ = 8;
            // Counted from the base before it is scaled up: the far end may be at 2^60 steps.
            to_steps_ = std::ldexp(1 / scale, coding.bits);
            base_ = coding.base;
        }
        most_ = (int64_t(0xffffffff) << extra_);
    }

    // w: 1 / (depth * scale).
    uint64_t of_inverse(double w) const {
        return clamped(int64_t(std::bit_cast<uint64_t>(w) >> shift_) - base_);
    }
    // z: depth * scale.
    uint64_t of_depth(double z) const {
        const double steps = std::clamp((-z * to_steps_ - double(base_)) * 256, 0.0, double(most_));
        return clamped(int64_t(steps));
    }
    uint32_t code(uint64_t key) const {
        const uint64_t half = extra_ > 0 ? uint64_t(1) << (extra_ - 1) : 0;
        return uint32_t(std::min<uint64_t>((key + half) >> extra_, 0xffffffff));
    }

  private:
    uint64_t clamped(int64_t key) const {
        return uint64_t(std::clamp<int64_t>(key, int64_t(1) << extra_, most_));
    }

    int extra_ = 0, shift_ = 0;
    int64_t base_ = 0, most_ = 0;
    double to_steps_ = 0;
};

inline uint64_t word_of(uint64_t key, uint32_t colour) {
    return key << 24 | colour;
}

// The larger one stays.
inline void raise(uint64_t& word, uint64_t to) {
    std::atomic_ref<uint64_t> at(word);
    uint64_t was = at.load(std::memory_order_relaxed);
    while (was < to && !at.compare_exchange_weak(was, to, std::memory_order_relaxed)) {
    }
}

inline void raise(uint16_t& value, uint16_t to) {
    std::atomic_ref<uint16_t> at(value);
    uint16_t was = at.load(std::memory_order_relaxed);
    while (was < to && !at.compare_exchange_weak(was, to, std::memory_order_relaxed)) {
    }
}

}  // namespace ppve
