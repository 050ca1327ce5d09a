// Boxes of triangles on the screen, as many at a time as the machine's vectors hold.
#include "render/triangle_bins.h"

#include <cfloat>
#include <cstring>
#include <utility>

#include "render/exact_triangle.h"

// Vectors are members of structs here, which those of unknown length cannot be; ARM has NEON as well.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/triangle_bins.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/lanes-inl.h"
#include "render/octahedral-inl.h"

#ifndef RENDER_TRIANGLE_BINS_ONCE
#define RENDER_TRIANGLE_BINS_ONCE
namespace render {

// A batch on its way to the bins.
struct TrianglesToBin {
    static constexpr size_t kCapacity = geom::TriangleBatch::kCapacity;
    static constexpr size_t kMostLanes = 64;
    alignas(64) float corners[3][4 * kCapacity];
    // Pixels of the picture: x, and y in the high half.
    alignas(64) uint32_t first[kCapacity], last[kCapacity];
    // Those to be binned; with kClose where a corner is not before the eye, or hardly.
    uint32_t list[kCapacity + kMostLanes];
    size_t count = 0;
    static constexpr uint32_t kClose = 1u << 31;
};

}  // namespace render
#endif

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

static_assert(hn::MaxLanes(F()) <= TrianglesToBin::kMostLanes);

// First and last pixel of an axis whose centres lie in a range of the picture, and of these the raster's.
struct SeenPixels {
    V first, last;
    hn::Mask<F> is_seen;
};

HWY_INLINE SeenPixels pixels_between(V low, V high, double principal, int picture, int begin, int size) {
    const F d;
    // More than float can be off by.
    const float off_by =
        1.0e-3f + 1.0e-6f * (static_cast<float>(std::abs(principal)) + static_cast<float>(picture));
    const V first = hn::Sub(low, hn::Set(d, 0.5f + off_by)), last = hn::Sub(high, hn::Set(d, 0.5f - off_by));
    SeenPixels range;
    range.first = hn::Ceil(hn::Max(first, hn::Zero(d)));
    range.last = hn::Floor(hn::Min(last, hn::Set(d, static_cast<float>(picture - 1))));
    const V seen_first = hn::Max(range.first, hn::Set(d, static_cast<float>(begin)));
    const V seen_last = hn::Min(range.last, hn::Set(d, static_cast<float>(begin + size - 1)));
    range.is_seen = hn::Le(seen_first, seen_last);
    return range;
}

void find_boxes(const SetupParams& params, const geom::TriangleBatch& batch, TrianglesToBin& out) {
    const F d;
    const U du;
    const geom::View& view = params.view;
    const V one = hn::Set(d, 1.0f), focal = hn::Set(d, static_cast<float>(view.focal_px));
    const glm::dvec2 principal = view.principal();
    const V middle_x = hn::Set(d, static_cast<float>(principal.x)),
            middle_y = hn::Set(d, static_cast<float>(principal.y));
    const size_t count = static_cast<size_t>(batch.count);
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        V low_x, low_y, high_x, high_y, nearest;
        for (size_t k = 0; k < 3; ++k) {
            const V x = hn::Load(d, batch.x[k] + i), y = hn::Load(d, batch.y[k] + i),
                    z = hn::Load(d, batch.z[k] + i);
            const auto code = octahedral_codes(d, hn::Load(d, batch.nx[k] + i), hn::Load(d, batch.ny[k] + i),
                                               hn::Load(d, batch.nz[k] + i));
            hn::StoreInterleaved4(x, y, z, hn::BitCast(d, code), d, out.corners[k] + 4 * i);
            const V inverse_z = hn::Div(one, z);
            const V px = hn::Add(hn::Mul(hn::Mul(x, inverse_z), focal), middle_x);
            const V py = hn::Add(hn::Mul(hn::Mul(y, inverse_z), focal), middle_y);
            low_x = k == 0 ? px : hn::Min(low_x, px), high_x = k == 0 ? px : hn::Max(high_x, px);
            low_y = k == 0 ? py : hn::Min(low_y, py), high_y = k == 0 ? py : hn::Max(high_y, py);
            nearest = k == 0 ? z : hn::Min(nearest, z);
        }
        const SeenPixels xs =
            pixels_between(low_x, high_x, principal.x, view.picture_width(), view.margins.left, view.width);
        const SeenPixels ys =
            pixels_between(low_y, high_y, principal.y, view.picture_height(), view.margins.top, view.height);
        const auto clear = hn::Ge(nearest, hn::Set(d, FLT_MIN));
        const auto unseen = hn::And(clear, hn::Not(hn::And(xs.is_seen, ys.is_seen)));
        const auto wanted = hn::RebindMask(du, hn::AndNot(unseen, hn::FirstN(d, count - i)));
        const auto boxed = hn::RebindMask(du, hn::And(clear, hn::And(xs.is_seen, ys.is_seen)));
        hn::Store(hn::IfThenElseZero(boxed, pack_pixels(xs.first, ys.first)), du, out.first + i);
        hn::Store(hn::IfThenElseZero(boxed, pack_pixels(xs.last, ys.last)), du, out.last + i);
        const auto close = hn::IfThenZeroElse(hn::RebindMask(du, clear), hn::Set(du, TrianglesToBin::kClose));
        const auto item = hn::Or(hn::Iota(du, static_cast<uint32_t>(i)), close);
        hn::StoreU(hn::Compress(item, wanted), du, out.list + out.count);
        out.count += hn::CountTrue(du, wanted);
    }
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace render {

HWY_EXPORT(find_boxes);

namespace {

// The box of a triangle that reaches to the eye's plane, of the raster's pixels.  False: it is not to be
// seen.
bool look_closely(const SetupParams& params, const geom::TriangleBatch& batch, size_t i,
                  TrianglesToBin& triangles) {
    const Raster raster(params.view, 1);
    Ray rays[3];
    for (size_t k = 0; k < 3; ++k) {
        rays[k] = ray_of(params.view, batch.x[k][i], batch.y[k][i], batch.z[k][i]);
        if (!std::isfinite(rays[k].x + rays[k].y + rays[k].z)) return false;
    }
    const Span all =
        least(least(span_of(raster, rays[0]), span_of(raster, rays[1])), span_of(raster, rays[2]));
    const PixelBox box = box_of(raster, all, rays[0], rays[1], rays[2]);
    if (box.empty()) return false;
    const auto packed = [&](int x, int y) {
        return uint32_t(x + raster.left) | uint32_t(y + raster.top) << 16;
    };
    triangles.first[i] = packed(box.first_x, box.first_y);
    triangles.last[i] = packed(box.last_x, box.last_y);
    return true;
}

void pack(const TrianglesToBin& from, size_t i, uint32_t colour, PackedTriangle& to) {
    for (size_t k = 0; k < 3; ++k) std::memcpy(to.corners[k], from.corners[k] + 4 * i, sizeof(to.corners[k]));
    to.x0 = uint16_t(from.first[i]), to.y0 = uint16_t(from.first[i] >> 16);
    to.x1 = uint16_t(from.last[i]), to.y1 = uint16_t(from.last[i] >> 16);
    to.colour = colour;
}

}  // namespace

void TriangleBins::begin(int tiles_across, int tiles_down) {
    ends_.resize(size_t(tiles_across) * size_t(tiles_down));
    triangles_.begin();
    sorted_.begin();
    entries_.clear();
}

void TriangleBins::add(const SetupParams& params, const geom::TriangleBatch& batch) {
    TrianglesToBin found;
    HWY_DYNAMIC_DISPATCH(find_boxes)(params, batch, found);
    const TileGrid grid(params.view);
    PackedTriangle* to = triangles_.take(found.count);
    for (size_t n = 0; n < found.count; ++n) {
        const size_t i = found.list[n] & ~TrianglesToBin::kClose;
        if (found.list[n] != i && !look_closely(params, batch, i, found)) continue;
        pack(found, i, batch.colour[i], *to);
        put(*to++, grid);
    }
}

void TriangleBins::put(const PackedTriangle& triangle, const TileGrid& grid) {
    // Of a box that may reach beyond the raster.
    const auto tile = [](int pixel, int size, int begin, int count) {
        return std::clamp(int(unsigned(pixel) / unsigned(size)) - begin, 0, count - 1);
    };
    const int x0 = tile(triangle.x0, kTileWidth, grid.left, grid.across);
    const int x1 = tile(triangle.x1, kTileWidth, grid.left, grid.across);
    const int y1 = tile(triangle.y1, kTileHeight, grid.top, grid.down);
    for (int y = tile(triangle.y0, kTileHeight, grid.top, grid.down); y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) entries_.push_back({uint32_t(y * grid.across + x), &triangle});
}

void TriangleBins::end_task(std::vector<TriangleRun>& runs) {
    if (entries_.empty()) return;
    std::fill(ends_.begin(), ends_.end(), 0u);
    for (const Entry& entry : entries_) ++ends_[entry.tile];
    const PackedTriangle** const sorted = sorted_.take(entries_.size());
    uint32_t begin = 0;
    for (uint32_t tile = 0; tile < ends_.size(); ++tile) {
        const uint32_t count = std::exchange(ends_[tile], begin);
        if (count > 0) runs.push_back({tile, count, sorted + begin});
        begin += count;
    }
    for (const Entry& entry : entries_) sorted[ends_[entry.tile]++] = entry.triangle;
    entries_.clear();
}

}  // namespace render
#endif
