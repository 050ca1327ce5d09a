// A tile's blocks of pixels as vectors.
// (Highway per-target header: included once for each instruction set.)
#if defined(RENDER_TILE_BLOCKS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RENDER_TILE_BLOCKS_INL_H_
#undef RENDER_TILE_BLOCKS_INL_H_
#else
#define RENDER_TILE_BLOCKS_INL_H_
#endif

#include <hwy/highway.h>

#include "render/tile.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A block, or an equal part of one.
using F = hn::CappedTag<float, kBlockPixels>;
using V = hn::Vec<F>;
using M = hn::Mask<F>;
using U = hn::RebindToUnsigned<F>;

// Pixel offsets of a block's lanes.
alignas(64) constexpr float kLaneX[kBlockPixels] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
alignas(64) constexpr float kLaneY[kBlockPixels] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};

HWY_INLINE size_t block_index(int x, int y) {
    return size_t(y / kBlockSize * kBlocksAcross + x / kBlockSize);
}

HWY_INLINE void store_where(M mask, V value, float* HWY_RESTRICT at) {
    const F d;
    hn::Store(hn::IfThenElse(mask, value, hn::Load(d, at)), d, at);
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
