// Blocks of a picture's pixels that spheres may cover, and what covers these: the arithmetic of OcclusionMap,
// as many spheres at a time as the machine's vectors hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "geom/occlusion.h"

namespace geom {

// The blocks of a raster, and the view's projection onto them.
struct BlockGrid {
    int left = 0, top = 0, right = 0, bottom = 0;  // pixels of the raster, without the last two
    int first_x = 0, first_y = 0;                  // its first block, of the picture's
    int across = 0, down = 0;                      // blocks
    float focal = 1, centre_x = 0, centre_y = 0, near = 0;

    size_t count() const { return size_t(across) * size_t(down); }
    size_t index(int bx, int by) const { return size_t(by) * size_t(across) + size_t(bx); }
};

// What is nearer than this many of its radii is never hidden: its splats may reach to the eye's plane.
constexpr float kClearRadii = 4;

// Blocks by sphere, inclusive; none where the last is before the first.
struct SphereBlocks {
    alignas(64) int32_t x0[OcclusionMap::Spheres::kCapacity], y0[OcclusionMap::Spheres::kCapacity],
        x1[OcclusionMap::Spheres::kCapacity], y1[OcclusionMap::Spheres::kCapacity];
};

// Where a sphere, or a square or disc inside of it that faces the screen, may cover a pixel.
void find_blocks(const BlockGrid& grid, const OcclusionMap::Spheres& spheres, SphereBlocks& blocks);

// Inverse depths of what surely covers squares of 1, 2, 4, ... blocks, from each block on: the least of the
// square. Any box is covered by four of them that overlap.
struct Covers {
    static constexpr int kLevels = 5;
    static constexpr int kPad = 1 << (kLevels - 1);  // columns behind each row, for squares that reach beyond

    const float*
        level[kLevels];  // level n: from its first block on; all in one array, levels one after the other
    int stride = 0;      // of rows
    int level_size = 0;
};

// What was found of each sphere.
struct Looked {
    SphereBlocks blocks;
    alignas(64) int32_t sights[OcclusionMap::Spheres::kCapacity];  // OcclusionMap::Sight
    // Where it is hidden: no fragment within it has an inverse depth, or one plus its push, above this.
    alignas(64) float limits[OcclusionMap::Spheres::kCapacity];
};
void look_at(const BlockGrid& grid, const Covers& covers, const OcclusionMap::Spheres& spheres,
             Looked& looked);

// Raises what stands in `nearest`, by block, to the inverse depths of the surfaces in the blocks' middles.
// Reads and writes what it found up to kBlocksBeyond beyond the last block.
constexpr size_t kBlocksBeyond = 8;
void cover_blocks(const BlockGrid& grid, std::span<const OcclusionMap::Surface> surfaces, float* nearest);

}  // namespace geom
