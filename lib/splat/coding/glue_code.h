// How a run says which edge of an earlier triangle the next one is glued to (triangle_run.h).
#pragma once

#include <bit>
#include <cstdint>

#include "splat/triangle_run.h"

namespace splat {

// Which edge a triangle is glued to: how many triangles back, which one, and what that took.
struct GlueCode {
    uint32_t back, edge, bits;
};

// From the bits behind the one that says so.  back: more than there can be triangles, where it is none.
constexpr GlueCode long_glue_code(uint64_t word) {
    const auto zeros = uint32_t(std::countr_zero(word));
    if (zeros >= kRunTriangleBits) return {kMostRunTriangles, 0, 1};
    const auto back = uint32_t(word >> (zeros + 1) & ((1u << zeros) - 1)) | 1u << zeros;
    word >>= 2 * zeros + 1;
    const uint32_t is_later = word & 1;
    return {back, is_later + (is_later & uint32_t(word >> 1)), 2 * zeros + 2 + is_later};
}

}  // namespace splat
