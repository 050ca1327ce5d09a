// Drawing one tile of the picture: all its splats in their order, then those of its pixels that are in the
// frame.
//
// A tile is cut into blocks of 4 x 4 pixels, and a block's state lies together, each quantity as one cache
// line: a vector of 16, 8 or 4 lanes is a block, its half or its row, loads never straddle lines,
// and the next splat finds what the last one stored at the same address and width.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "geom/occlusion.h"
#include "render/splat_record.h"

namespace render {

inline constexpr int kBlockSize = 4;
inline constexpr int kBlockPixels = kBlockSize * kBlockSize;
inline constexpr int kBlocksAcross = kTileWidth / kBlockSize;  // a tile
inline constexpr int kMaxPlanes = 12;
inline constexpr size_t kTileStateFloats = size_t(kTileWidth) * kTileHeight * kMaxPlanes;

struct TileTriangles;

struct TileJob {
    int x0, y0;                    // first sample, of the picture
    int left, top, right, bottom;  // the part in the raster, counted from there; without the last two
    size_t frame_at;               // pixel of the frame that its (left, top) is
    std::span<const TileRun> runs;
    std::span<const NearSplat> near_splats;
    const TileTriangles* triangles = nullptr;  // null: there are none
    // Of what is not among these because it is hidden; null: nothing is.
    geom::OcclusionMap* map = nullptr;
};

// What a thread draws with; contents of no matter.
struct TileScratch {
    alignas(64) float state[kTileStateFloats];
    SplatRecord records[SplatChunk::kCapacity];
    std::vector<NearSplat> near_splats;
    // By block of pixels: nearest inverse depth of what is hidden there; 0: nothing is.
    float limits[size_t(kTileWidth / kBlockSize) * (kTileHeight / kBlockSize)];
};

// Writes the tile's pixels to `frame`, which has the view's size already.  Different tiles may be drawn at
// once. With a map: marks its blocks where what is hidden may show; once it is repeated, writes those only.
void draw_tile(const SetupParams& params, const TileJob& job, TileScratch& scratch, Frame& frame);

// What the machine's vectors are called, "AVX2" say.
const char* instruction_set();

}  // namespace render
