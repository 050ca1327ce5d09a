// Drawing one tile of the screen: all its splats in their order, then the tile's pixels of the frame.
//
// A tile is cut into blocks of 4 x 4 pixels, and a block's state lies together, each quantity as one cache
// line: a vector of 16, 8 or 4 lanes is a block, its half or its row, loads never straddle lines,
// and the next splat finds what the last one stored at the same address and width.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "render/splat_record.h"

namespace render {

// 230,000 splats of 3 px, smooth: 5.6 ms; tiles of 64 x 64 6.2 ms, of 32 x 32 6.5 ms.
inline constexpr int kTileWidth = 64;
inline constexpr int kTileHeight = 32;
inline constexpr int kBlockSize = 4;
inline constexpr int kBlockPixels = kBlockSize * kBlockSize;
inline constexpr int kMaxPlanes = 10;
inline constexpr size_t kTileStateFloats = size_t(kTileWidth) * kTileHeight * kMaxPlanes;

// Splats of one task in one tile: records[order[0..count)].
struct TileRun {
    const SplatRecord* records;
    const uint32_t* order;
    uint32_t count;
};

struct TileJob {
    int x0, y0;         // first pixel
    int width, height;  // of the part on the screen
    std::span<const TileRun> runs;
    std::span<const NearSplat> near_splats;
};

// `state`: kTileStateFloats, aligned to 64, contents of no matter.  Writes every pixel of the tile to
// `frame`, which has the view's size already.  Different tiles may be drawn at once.
void draw_tile(const SetupParams& params, const TileJob& job, float* state, Frame& frame);

}  // namespace render
