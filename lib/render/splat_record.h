// What is kept of a splat between its set-up and the tiles it is drawn in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/frame.h"
#include "render/splatter.h"

namespace render {

// A splat wholly before the eye, ready to be sampled; one cache line.  With (dx, dy) = the offset in
// pixels of a pixel's centre from the outline's, its coordinates in the outline's own frame are
//     a = l1 dx + l2 dy,  b = l3 dy,     so that  t = 1 - a a - b b  is 1 in the middle,
// falls to kEdge at the outline, and is a sum of squares: in float it is as good for a splat
// seen edge-on (where the textbook's polynomial cancels) as for a round one.  A square is max(|a|, |b|) <= 1.
struct alignas(64) SplatRecord {
    uint16_t x0, y0, x1, y1;  // pixels whose centres may be inside, inclusive, on the screen
    float dx0, dy0;           // (dx, dy) of pixel (x0, y0)
    float l1, l2, l3;         // 1/px
    float push;               // R along the ray through the centre, as a step of inverse depth
    float w, w_dx, w_dy;      // inverse depth at the outline's centre, and its slopes per px
    uint32_t colour;          // 0x00BBGGRR: material where blended, else what is written
    float nx, ny, nz;         // normal
    float unused;
};
static_assert(sizeof(SplatRecord) == 64);

// Value of t at the outline.  Not 0, so that a pixel covered by a rim alone still has a weight to
// divide by; 1/256 squared is no more than one level of 255 against any splat's middle.
inline constexpr float kEdge = 1.0f / 256.0f;

// A splat that contains the eye, or reaches to its plane or nearly so.  Its outline may be any conic, so
// that each pixel's ray is intersected.  Lengths in units of its radius.
struct NearSplat {
    uint16_t x0, y0, x1, y1;  // as in SplatRecord
    float px, py, pz;
    float nx, ny, nz;
    float flatness_squared;
    float inverse_radius;  // 1/world units
    uint32_t colour;       // as in SplatRecord
};

struct SetupParams {
    geom::View view;
    SplatterOptions options;
    // Inverse depths, in those of the splats, of the view's far and near: nothing else is drawn.
    float least_w, most_w;

    bool has_limits() const { return view.near || view.far; }
};

// Pixels that a number of splats lie in, inclusive; empty to begin with.
struct PixelBox {
    int x0 = 65535, y0 = 65535, x1 = 0, y1 = 0;
};

// Projects a batch, writes the records of what may cover a pixel's centre to `out` (room for
// batch.count), widens `box` by them, and returns how many; appends the others to `near_splats`.
size_t set_up_splats(const SetupParams& params, const SplatBatch& batch, SplatRecord* out, PixelBox& box,
                     std::vector<NearSplat>& near_splats);

}  // namespace render
