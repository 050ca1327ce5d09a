// Drawing the triangles of one tile of the picture, before its splats.
//
// What a triangle covers is decided as MeshRaster does it, to the pixel: most pixels by edge functions in
// single precision, whose error is known; those that it leaves in doubt by exact_triangle.h.  Triangles that
// are no matter for single precision (slivers, those that reach behind the eye) go that way as a whole.  The
// nearest fragment has the pixel, of equal ones the first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/triangle_bins.h"

namespace render {

inline constexpr size_t kTilePixels = size_t(kTileWidth) * kTileHeight;

// A tile by its blocks, one after the other, as in tile.h.
struct TileTriangles {
    alignas(64) float w[kTilePixels];          // inverse depth
    alignas(64) uint32_t colour[kTilePixels];  // 0x00BBGGRR, as it is to be shown
};

// Inverse depth of pixels without a triangle, and less.
inline constexpr float kNoTriangle = -3.0e38f;

// A triangle ready to be sampled in one tile.
struct alignas(64) TriangleRecord {
    // What is linear in the picture, by its value in the first pixel of the first block and its slopes per
    // pixel: the edge functions, which are the corners' weights but for a factor; inverse depth; the weighted
    // normal.
    enum { kEdges = 0, kW = 3, kNormal = 4, kPlanes = 8 };
    alignas(32) float at[kPlanes], dx[kPlanes], dy[kPlanes];
    float doubt;            // no edge function is off by more, in the box
    float least_w, most_w;  // of the corners
    uint32_t colour;
    uint8_t block_x0, block_y0, block_x1, block_y1;  // of the tile, inclusive
    bool is_exact;                                   // to be drawn by exact_triangle.h; without planes then
    const PackedTriangle* triangle;
};

// What a thread draws with; contents of no matter.
struct TriangleScratch {
    static constexpr size_t kGroup = 64;  // triangles set up at a time; a multiple of every vector length

    TileTriangles shown;
    alignas(64) float normals[3][kTilePixels];
    alignas(64) float corners[3][4 * kGroup];
    alignas(64) float first_x[kGroup], first_y[kGroup];  // pixel of the picture, the first of the first block
    alignas(64) float width[kGroup], height[kGroup];     // from there to the last pixel
    alignas(64) float planes[4][3][kGroup];              // of TriangleRecord: at, dx, dy
    alignas(64) float doubt[kGroup], least_w[kGroup], most_w[kGroup];
    TriangleRecord records[kGroup];
    std::vector<const PackedTriangle*> triangles;  // of all runs
};

// Draws the triangles of the tile whose first pixel of the picture is (x0, y0): all of scratch.shown.
void draw_triangles(const SetupParams& params, int x0, int y0, std::span<const TriangleRun> runs,
                    TriangleScratch& scratch);

}  // namespace render
