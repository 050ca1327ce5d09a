// Sorting splats into tiles, as many at a time as the machine's vectors hold.
#include <algorithm>
#include <bit>
#include <cstring>

#include "render/splat_record.h"

// Vectors are members of structs here, which those of unknown length cannot be; ARM has NEON as well.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/splat_bins.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/splat_outline-inl.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

// Splats farther away than this many radii are wholly before the eye, whatever their shape.
constexpr float kClearRadii = 2;

// Pixels, as pack_pixels(), to tiles.
HWY_INLINE hn::Vec<U> tiles_of(hn::Vec<U> pixels) {
    constexpr int kShiftX = std::countr_zero(unsigned(kTileWidth)),
                  kShiftY = std::countr_zero(unsigned(kTileHeight));
    const U du;
    const auto x = hn::ShiftRight<kShiftX>(hn::And(pixels, hn::Set(du, 0xffffu)));
    const auto y = hn::ShiftRight<16 + kShiftY>(pixels);
    return hn::Or(x, hn::ShiftLeft<16>(y));
}

// A batch on its way to the bins.
struct SplatsToBin {
    alignas(64) float place[4 * SplatBatch::kCapacity], facing[4 * SplatBatch::kCapacity];
    // Tiles that each may lie in, counted from the raster's first: x, and y in the high half; and the first
    // of them by number.
    alignas(64) uint32_t first[SplatBatch::kCapacity], last[SplatBatch::kCapacity],
        tile[SplatBatch::kCapacity];
    // Those to be binned, kWide and kClose being added to their indices.
    uint32_t list[SplatBatch::kCapacity + kMaxLanes];
    size_t count = 0;
    static constexpr uint32_t kWide = 1u << 30;   // in more than one tile
    static constexpr uint32_t kClose = 1u << 31;  // may reach to the eye's plane
};

// A splat that may reach to the eye's plane: its set-up says what it is, and which tiles it lies in.
HWY_NOINLINE bool look_closely(const SetupParams& params, size_t i, uint32_t colour, SplatsToBin& splats,
                               std::vector<NearSplat>& near_splats) {
    SplatChunk one;
    std::memcpy(one.place, splats.place + 4 * i, sizeof(float) * 4);
    std::memcpy(one.facing, splats.facing + 4 * i, sizeof(float) * 4);
    ColourChunk colours;
    colours.of[0] = colour;
    SplatRecord record;
    if (set_up_splats(params, one, colours, 1, &record, near_splats) == 0) return false;
    const geom::View& view = params.view;
    const int left = view.margins.left, right = left + view.width - 1;
    const int top = view.margins.top, bottom = top + view.height - 1;
    if (record.x1 < left || record.x0 > right || record.y1 < top || record.y0 > bottom) return false;
    const TileGrid grid(view);
    const auto tile = [&](int x, int y) {
        return uint32_t(x / kTileWidth - grid.left) | uint32_t(y / kTileHeight - grid.top) << 16;
    };
    splats.first[i] = tile(std::max<int>(record.x0, left), std::max<int>(record.y0, top));
    splats.last[i] = tile(std::min<int>(record.x1, right), std::min<int>(record.y1, bottom));
    return true;
}

// Finds the tiles of a batch's splats.
HWY_INLINE void find_tiles(const SetupParams& params, int tiles_across, const SplatBatch& batch,
                           SplatsToBin& out) {
    const F d;
    const U du;
    const geom::View& view = params.view;
    const bool aligned = params.options.kind == SplatKind::square || params.options.kind == SplatKind::circle;
    const V one = hn::Set(d, 1.0f), focal = hn::Set(d, static_cast<float>(view.focal_px));
    const glm::dvec2 principal = view.principal();
    const TileGrid grid(view);
    const auto first_tile =
        hn::Set(du, static_cast<uint32_t>(grid.left) | static_cast<uint32_t>(grid.top) << 16);
    const size_t count = static_cast<size_t>(batch.count);
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        const V x = hn::Load(d, batch.x + i), y = hn::Load(d, batch.y + i), z = hn::Load(d, batch.z + i);
        const V radius = hn::Load(d, batch.radius + i), flatness = hn::Load(d, batch.flatness + i);
        const V nx = hn::Load(d, batch.nx + i), ny = hn::Load(d, batch.ny + i),
                nz = hn::Load(d, batch.nz + i);
        const V inverse_z = hn::Div(one, z);
        const V r = hn::Mul(radius, inverse_z);
        const V g = aligned ? hn::Zero(d) : hn::Sub(one, square(flatness));  // 0: as wide as its sphere
        const auto range = [&](V t, V n, double middle, int begin, int size) HWY_ATTR {
            const V centre = hn::Add(hn::Mul(t, focal), hn::Set(d, static_cast<float>(middle)));
            // Larger by more than float can be off by.
            const V extent = hn::Mul(hn::Mul(focal, outline_reach(r, t, g, n, nz)), hn::Set(d, 1.001f));
            const V off_by = hn::Set(d, 1.0e-3f + static_cast<float>(begin + size) * 1.0e-6f);
            return pixel_range(centre, hn::Add(extent, off_by), begin, size);
        };
        const PixelRange xs = range(hn::Mul(x, inverse_z), nx, principal.x, view.margins.left, view.width);
        const PixelRange ys = range(hn::Mul(y, inverse_z), ny, principal.y, view.margins.top, view.height);
        const auto clear = hn::Gt(z, hn::Mul(radius, hn::Set(d, kClearRadii)));  // false for NaN
        const auto unseen = hn::And(clear, hn::Not(hn::And(xs.any, ys.any)));
        const auto wanted = hn::RebindMask(du, hn::AndNot(unseen, hn::FirstN(d, count - i)));

        const auto first = hn::Sub(tiles_of(pack_pixels(xs.first, ys.first)), first_tile),
                   last = hn::Sub(tiles_of(pack_pixels(xs.last, ys.last)), first_tile);
        const auto row = hn::Mul(hn::ShiftRight<16>(first), hn::Set(du, static_cast<uint32_t>(tiles_across)));
        hn::Store(first, du, out.first + i);
        hn::Store(last, du, out.last + i);
        hn::Store(hn::Add(row, hn::And(first, hn::Set(du, 0xffffu))), du, out.tile + i);
        hn::StoreInterleaved4(x, y, z, radius, d, out.place + 4 * i);
        hn::StoreInterleaved4(nx, ny, nz, flatness, d, out.facing + 4 * i);
        const auto close_flag =
            hn::IfThenZeroElse(hn::RebindMask(du, clear), hn::Set(du, SplatsToBin::kClose));
        const auto wide_flag = hn::IfThenZeroElse(hn::Eq(first, last), hn::Set(du, SplatsToBin::kWide));
        const auto item = hn::Or(hn::Or(hn::Load(du, kLaneNumbers.of), hn::Set(du, static_cast<uint32_t>(i))),
                                 hn::Or(close_flag, wide_flag));
        hn::StoreU(hn::Compress(item, wanted), du, out.list + out.count);
        out.count += hn::CountTrue(du, wanted);
    }
}

void bin_splats(const SetupParams& params, const SplatBatch& batch, TileBins& bins,
                std::vector<TileRun>& runs, std::vector<NearSplat>& near_splats) {
    SplatsToBin splats;
    const uint32_t across = static_cast<uint32_t>(bins.tiles_across());
    find_tiles(params, bins.tiles_across(), batch, splats);
    const bool has_colour = params.options.has_colour;
    const auto put = [&](size_t i, uint32_t tile) {
        const TileBins::Place to = bins.next(tile, runs);
        std::memcpy(to.chunk->place + 4 * to.at, splats.place + 4 * i, sizeof(float) * 4);
        std::memcpy(to.chunk->facing + 4 * to.at, splats.facing + 4 * i, sizeof(float) * 4);
        if (has_colour) to.colours->of[to.at] = batch.colour[i];
    };
    for (size_t n = 0; n < splats.count; ++n) {
        const uint32_t item = splats.list[n];
        const size_t i = item & (SplatsToBin::kWide - 1);
        if (item < SplatsToBin::kWide) {  // nearly all
            put(i, splats.tile[i]);
            continue;
        }
        if ((item & SplatsToBin::kClose) && !look_closely(params, i, batch.colour[i], splats, near_splats))
            continue;
        for (uint32_t y = splats.first[i] >> 16; y <= splats.last[i] >> 16; ++y) {
            for (uint32_t x = splats.first[i] & 0xffffu; x <= (splats.last[i] & 0xffffu); ++x)
                put(i, y * across + x);
        }
    }
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace render {

HWY_EXPORT(bin_splats);

void bin_splats(const SetupParams& params, const SplatBatch& batch, TileBins& bins,
                std::vector<TileRun>& runs, std::vector<NearSplat>& near_splats) {
    HWY_DYNAMIC_DISPATCH(bin_splats)(params, batch, bins, runs, near_splats);
}

}  // namespace render
#endif
