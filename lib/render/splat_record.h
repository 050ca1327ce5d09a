// What is kept of a splat on its way from its batch to the pixels: first what came, sorted into tiles; then,
// a tile at a time, what it takes to sample it.  A sampled splat is as long as a cache line, and many cover
// no pixel: keeping those of a whole frame would cost more in memory traffic than setting some up in two
// tiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/shading.h"
#include "render/splatter.h"
#include "render/tile_bins.h"

namespace render {

// A splat wholly before the eye, ready to be sampled; one cache line.  With (dx, dy) = the offset in
// pixels of a pixel's centre from the outline's, its coordinates in the outline's own frame are
//     a = l1 dx + l2 dy,  b = l3 dy,     so that  t = 1 - a a - b b  is 1 in the middle,
// falls to kEdge at the outline, and is a sum of squares: in float it is as good for a splat
// seen edge-on (where the textbook's polynomial cancels) as for a round one.  A square is max(|a|, |b|) <= 1.
struct alignas(64) SplatRecord {
    uint16_t x0, y0, x1, y1;  // pixels of the picture whose centres may be inside, inclusive
    float dx0, dy0;           // (dx, dy) of pixel (x0, y0)
    float l1, l2, l3;         // 1/px
    float push;  // R along the ray through the centre, as a step of inverse depth; blended: kReach of it
    float w, w_dx, w_dy;     // inverse depth at the outline's centre, and its slopes per px
    uint32_t colour;         // 0x00BBGGRR: material where blended, else what is written
    float nx, ny, nz;        // normal
    int16_t core_a, core_b;  // see kCoreScale
};
static_assert(sizeof(SplatRecord) == 64);

// Value of t at the outline.  Not 0, so that a pixel covered by a rim alone still has a weight to
// divide by; 1/256 is no more than one level of 255 against any splat's middle.
inline constexpr float kEdge = 1.0f / 256.0f;

// Splats that are blended are this part of R in depth from the nearest: kReach and kReachByFlatness times the
// flatness, over the cosine between normal and ray, at most all of R.  Those of one surface are told apart in
// depth by what their planes are off, as seen along the ray; of two sheets that lie half an R apart only the
// nearer one is to be seen.  (All of R: of the dragon 0.1 dB more; of a CT head's plate, whose two sheets it
// mixes, 4 dB less.)
inline constexpr float kReach = 0.3f, kReachByFlatness = 1.5f;

// Where splats are blended, their depths over these: of two of a cut the smaller one knows better what the
// surface is like there.  (PSNR of scans at 1 px +0.13 dB against none; with t^2 for t, 0.05 dB less.)
inline constexpr float kMostGain = 1e9f;  // the square of 10^10 of it is a float
inline float gain_of(const SplatRecord& r) {
    return r.push * kMostGain > r.w ? r.w / r.push : kMostGain;
}

// Clearance is what is left of the depth before the eye, 1 - (extent in z / z)^2, a difference.  Below the
// first bound the outline, relative to which it is exact, is so much wider than the splat that the
// near end of it would be off by more than a thousandth of a pixel: such splats go by way of NearSplat. Below
// the second not even the outline's bounds are to be relied on.
inline constexpr float kMinClearance = 1.0f / 4.0f;
inline constexpr float kMinBoundedClearance = 1.0f / 64.0f;

// Nothing is thinner: keeps the ratios of the axes, and their squares, within float.
inline constexpr float kMinFlatness = 1.0f / 4096.0f;

// Outlines grow by this part of themselves, so that rounding cannot open a hole between two splats
// that share a boundary; one thousandth of a pixel at 100 px.
inline constexpr float kGrowth = 1.0e-5f;

// The core of a splat is where t - (s a + u b)^2 is at least kCoreEdge, for s, u = core_a, core_b /
// kCoreScale: the ellipsoid with kCoreFlatness of its thickness and 0.95 of its radius.
inline constexpr float kCoreScale = 2048, kCoreFlatness = 0.1f;
inline constexpr float kCoreEdge = 1 - 0.95f * 0.95f;

// The rest of the ellipsoid is its cover.  It is there so that there is no hole, and larger than the surface:
// where a surface ends before another, at a fold, covers would make it end too late.  So a pixel shows cores
// if it has any, however far behind covers: those are ordered by their inverse depths times kCoverOrder,
// which rounds nothing.  That is behind all cores up to four thousand million times as far as the cover.
// What is above kLeastCoreOrder is taken for a core: right from a depth of 2e-5 units up to one of 6e4.
inline constexpr float kCoverOrder = 0x1p-32f, kLeastCoreOrder = 0x1p-16f;

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

// The tiles that hold a view's raster: of the picture's, which begin at its first pixel.
struct TileGrid {
    int left, top, across, down;

    explicit TileGrid(const geom::View& view)
        : left(view.margins.left / kTileWidth),
          top(view.margins.top / kTileHeight),
          across((view.margins.left + view.width - 1) / kTileWidth + 1 - left),
          down((view.margins.top + view.height - 1) / kTileHeight + 1 - top) {}
    size_t count() const { return size_t(across) * size_t(down); }
};

// Its pixels, and those of tiles and records, are samples: Look::samples_across each way in one of the frame.
struct SetupParams {
    geom::View view;
    SplatterOptions options;
    Light light;
    // Inverse depths, in those of the splats, of the view's far and near: nothing else is drawn.
    float least_w, most_w;
    float triangle_lead;  // by which inverse depths of triangles are multiplied against those of splats

    SetupParams() = default;
    SetupParams(const geom::View& seen, const SplatterOptions& wanted);

    bool has_limits() const { return view.near || view.far; }
};

// Sorts the splats of a batch into the tiles they may lie in, but for those that surely cover no pixel's
// centre; appends to `runs` the chunks that it filled, and to `near_splats` the splats of that kind.
void bin_splats(const SetupParams& params, const SplatBatch& batch, TileBins& bins,
                std::vector<TileRun>& runs, std::vector<NearSplat>& near_splats);

// Projects the first `count` splats of a chunk, writes the records of what may cover a pixel's centre to
// `out` (room for `count`), and returns how many; appends near ones to `near_splats`.
size_t set_up_splats(const SetupParams& params, const SplatChunk& chunk, const ColourChunk& colours,
                     size_t count, SplatRecord* out, std::vector<NearSplat>& near_splats);

}  // namespace render
