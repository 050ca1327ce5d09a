#include "geom/occlusion_blocks.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "geom/occlusion_blocks.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef QS_GEOM_OCCLUSION_BLOCKS_ONCE
#define QS_GEOM_OCCLUSION_BLOCKS_ONCE
namespace geom {
namespace {

// Spheres that look smaller are not looked at: to leave them out would save no more than that costs.
constexpr float kLeastDiameterPx = 6;
constexpr float kInverseBlock = 1.0f / OcclusionMap::kBlock;
constexpr size_t kMaxLanes = 16;
static_assert(OcclusionMap::Spheres::kCapacity % kMaxLanes == 0);

}  // namespace
}  // namespace geom
#endif

HWY_BEFORE_NAMESPACE();
namespace geom::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kMaxLanes>;
using DI = hn::Rebind<int32_t, D>;
using V = hn::Vec<D>;
using I = hn::Vec<DI>;

// Along one axis of the picture.
struct Range {
    I first, last;
};

// Blocks from `middle` - `half` to `middle` + `half`, pixels, as far as the raster goes.
HWY_INLINE Range BlocksBetween(V middle, V half, int begin, int end, int first, int count) {
    const D d;
    const DI di;
    const V low = hn::Set(d, float(begin - 1)), high = hn::Set(d, float(end));
    // Written so that what is no number becomes one.
    const auto block = [&](V pixel) HWY_ATTR {
        const V from = hn::IfThenElse(hn::Gt(pixel, low), pixel, low);
        const V within = hn::IfThenElse(hn::Lt(high, from), high, from);
        return hn::Sub(hn::ConvertTo(di, hn::Floor(hn::Mul(within, hn::Set(d, kInverseBlock)))),
                       hn::Set(di, first));
    };
    return {hn::Max(block(hn::Sub(middle, half)), hn::Zero(di)),
            hn::Min(block(hn::Add(middle, half)), hn::Set(di, count - 1))};
}

struct Box {
    Range x, y;
};

// With r = radius / z the outline is about (x / z) / (1 - r^2), and at most r sqrt(1 + (x / z)^2) / (1 - r^2)
// wide to either side.
HWY_INLINE Box BlocksOf(const BlockGrid& grid, V x, V y, V z, V radius) {
    const D d;
    const V one = hn::Set(d, 1.0f);
    const V inverse_z = hn::Div(one, z), r = hn::Mul(radius, inverse_z), tx = hn::Mul(x, inverse_z),
            ty = hn::Mul(y, inverse_z);
    const V scale = hn::Div(hn::Set(d, grid.focal), hn::Sub(one, hn::Mul(r, r)));
    // More than float, and what splats reach beyond their outlines, can be off by.
    const V off_by = hn::Set(d, 0.02f + 1e-6f * float(grid.right + grid.bottom));
    const auto half = [&](V t) HWY_ATTR {
        return hn::Add(hn::Mul(hn::Mul(r, hn::Sqrt(hn::Add(one, hn::Mul(t, t)))), scale), off_by);
    };
    const V middle_x = hn::Add(hn::Set(d, grid.centre_x), hn::Mul(tx, scale)),
            middle_y = hn::Add(hn::Set(d, grid.centre_y), hn::Mul(ty, scale));
    return {BlocksBetween(middle_x, half(tx), grid.left, grid.right, grid.first_x, grid.across),
            BlocksBetween(middle_y, half(ty), grid.top, grid.bottom, grid.first_y, grid.down)};
}

HWY_INLINE void StoreBox(const Box& box, size_t i, SphereBlocks& to) {
    const DI di;
    hn::Store(box.x.first, di, to.x0 + i), hn::Store(box.x.last, di, to.x1 + i);
    hn::Store(box.y.first, di, to.y0 + i), hn::Store(box.y.last, di, to.y1 + i);
}

void FindBlocks(const BlockGrid& grid, const OcclusionMap::Spheres& spheres, SphereBlocks& blocks) {
    const D d;
    for (size_t i = 0; i < spheres.count; i += hn::Lanes(d))
        StoreBox(BlocksOf(grid, hn::Load(d, spheres.x + i), hn::Load(d, spheres.y + i),
                          hn::Load(d, spheres.z + i), hn::Load(d, spheres.radius + i)),
                 i, blocks);
}

// No fragment of what is within the sphere has an inverse depth w or push p (see below) so that w + p is
// above this. A fragment's depth is between the points where its ray meets its splat, so w <= 1 / near for
// near = z - radius. Its push, the step in w from its splat's centre, at depth z' with z' - R >= near, to its
// radius R behind it, is R / (z' (z' + R)) <= radius / near^2.  The hundredth covers what a splat's plane may
// rise to a thousandth of its size beyond its outline, the rest what float is off by and splats so small that
// they are drawn larger than they are (kMinRadiusPx of splat_setup.cpp).
HWY_INLINE V LimitOf(const BlockGrid& grid, V z, V radius) {
    const D d;
    const V one = hn::Set(d, 1.0f), grown = hn::Mul(hn::Set(d, 1.01f), radius);
    const V w = hn::Div(one, hn::Sub(z, grown));
    return hn::Mul(hn::Mul(w, hn::Add(one, hn::Mul(grown, w))), hn::Set(d, 1 + 1e-4f + 0.02f / grid.focal));
}

// The least and the most of the four squares that cover the box, which is nowhere empty; `fits` where four
// do.
struct Cover {
    V least, most;
    hn::Mask<DI> fits;
};
HWY_INLINE Cover CoverOf(const Covers& covers, const Box& box) {
    const D d;
    const DI di;
    const I one = hn::Set(di, 1);
    const I side = hn::Max(hn::Sub(box.x.last, box.x.first), hn::Sub(box.y.last, box.y.first));  // less one
    const I half = hn::ShiftRight<1>(side);
    // Squares of the least size of which two reach over the longer side.
    I level = hn::Zero(di), size = one;
    for (int n = 1; n < Covers::kLevels; ++n) {
        const auto is_longer = hn::Gt(half, hn::Set(di, (1 << (n - 1)) - 1));
        level = hn::IfThenElse(is_longer, hn::Set(di, n), level);
        size = hn::IfThenElse(is_longer, hn::Set(di, 1 << n), size);
    }
    const auto fits = hn::Lt(side, hn::Set(di, 2 << (Covers::kLevels - 1)));
    const auto second = [&](const Range& range) HWY_ATTR {
        return hn::Max(range.first, hn::Sub(hn::Add(range.last, one), size));
    };
    const I stride = hn::Set(di, covers.stride), first = hn::Mul(level, hn::Set(di, covers.level_size));
    const auto at = [&](I x, I y) HWY_ATTR {
        return hn::GatherIndex(d, covers.level[0], hn::Add(first, hn::Add(hn::Mul(y, stride), x)));
    };
    const I x1 = second(box.x), y1 = second(box.y);
    const V a = at(box.x.first, box.y.first), b = at(x1, box.y.first), c = at(box.x.first, y1),
            e = at(x1, y1);
    return {hn::Min(hn::Min(a, b), hn::Min(c, e)), hn::Max(hn::Max(a, b), hn::Max(c, e)), fits};
}

void LookAt(const BlockGrid& grid, const Covers& covers, const OcclusionMap::Spheres& spheres,
            Looked& looked) {
    using Sight = OcclusionMap::Sight;
    const D d;
    const DI di;
    for (size_t i = 0; i < spheres.count; i += hn::Lanes(d)) {
        const V z = hn::Load(d, spheres.z + i), radius = hn::Load(d, spheres.radius + i);
        const auto ahead = hn::Gt(z, hn::Mul(radius, hn::Set(d, kClearRadii)));
        const auto large =
            hn::Ge(hn::Mul(radius, hn::Set(d, 2 * grid.focal)), hn::Mul(z, hn::Set(d, kLeastDiameterPx)));
        const auto of = [&](Sight sight) HWY_ATTR { return hn::Set(di, int32_t(sight)); };
        I sight = hn::IfThenElse(hn::RebindMask(di, ahead), of(Sight::clear), of(Sight::partly));
        auto wanted = hn::RebindMask(di, hn::And(ahead, large));
        if (!hn::AllFalse(di, wanted)) {
            const Box box = BlocksOf(grid, hn::Load(d, spheres.x + i), hn::Load(d, spheres.y + i), z, radius);
            StoreBox(box, i, looked.blocks);
            wanted =
                hn::AndNot(hn::Or(hn::Lt(box.x.last, box.x.first), hn::Lt(box.y.last, box.y.first)), wanted);
            const auto only = [&](const Range& range) HWY_ATTR {
                return Range{hn::IfThenElseZero(wanted, range.first), hn::IfThenElseZero(wanted, range.last)};
            };
            const Cover cover = CoverOf(covers, {only(box.x), only(box.y)});
            const V limit = LimitOf(grid, z, radius);
            hn::Store(limit, d, looked.limits + i);
            const auto any = hn::RebindMask(di, hn::Gt(cover.most, hn::Div(hn::Set(d, 1.0f), z)));
            const auto all = hn::RebindMask(di, hn::Gt(cover.least, limit));
            sight =
                hn::IfThenElse(hn::And(wanted, hn::Or(any, hn::Not(cover.fits))), of(Sight::partly), sight);
            sight = hn::IfThenElse(hn::And(wanted, hn::And(all, cover.fits)), of(Sight::hidden), sight);
        }
        hn::Store(sight, di, looked.sights + i);
    }
}

// One surface, in the blocks where its outline may be.
HWY_INLINE void CoverBlocks(const BlockGrid& grid, const OcclusionMap::Surface& s, float towards,
                            const SphereBlocks& blocks, size_t i, float* nearest) {
    const hn::CappedTag<float, kBlocksBeyond> d;
    constexpr int kHalf = OcclusionMap::kBlock / 2;
    const float inverse_focal = 1 / grid.focal, inverse_towards = 1 / towards;
    // Splats in front must stand clear by about their radii, which this is more than.
    const float behind = s.thickness + s.radius;
    const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
    const auto zero = hn::Zero(d);
    const float nx = s.normal.x * inverse_towards, ny = s.normal.y * inverse_towards,
                nz = s.normal.z * inverse_towards;
    const auto px = set(s.centre.x), py = set(s.centre.y), pz = set(s.centre.z);
    const auto radius2 = set(s.radius * s.radius);
    const auto middles = hn::Mul(hn::Iota(d, 0.0f), set(float(OcclusionMap::kBlock)));
    const int lanes = int(hn::Lanes(d));
    for (int by = blocks.y0[i]; by <= blocks.y1[i]; ++by) {
        const float dy =
            (float((grid.first_y + by) * OcclusionMap::kBlock + kHalf) - grid.centre_y) * inverse_focal;
        const auto row_w = set(ny * dy + nz);
        for (int bx = blocks.x0[i]; bx <= blocks.x1[i]; bx += lanes) {
            // Where the ray (dx, dy, 1) through the block's middle meets the disc's plane: at depth 1 / w.
            const auto middle =
                hn::Add(set(float((grid.first_x + bx) * OcclusionMap::kBlock + kHalf)), middles);
            const auto dx = hn::Mul(hn::Sub(middle, set(grid.centre_x)), set(inverse_focal));
            const auto w = hn::Add(hn::Mul(set(nx), dx), row_w), w2 = hn::Mul(w, w);
            const auto off_x = hn::Sub(dx, hn::Mul(px, w)), off_y = hn::Sub(set(dy), hn::Mul(py, w)),
                       off_z = hn::Sub(set(1.0f), hn::Mul(pz, w));
            const auto off2 =
                hn::Add(hn::Add(hn::Mul(off_x, off_x), hn::Mul(off_y, off_y)), hn::Mul(off_z, off_z));
            const auto is_met = hn::And(hn::Gt(w, zero), hn::Le(off2, hn::Mul(radius2, w2)));
            const auto is_within = hn::FirstN(d, size_t(std::min(lanes, blocks.x1[i] - bx + 1)));
            const auto depth =
                hn::IfThenElseZero(hn::And(is_met, is_within), hn::Sub(w, hn::Mul(set(behind), w2)));
            float* to = nearest + grid.index(bx, by);
            hn::StoreU(hn::Max(hn::LoadU(d, to), depth), d, to);
        }
    }
}

void CoverAll(const BlockGrid& grid, std::span<const OcclusionMap::Surface> surfaces, float* nearest) {
    using Spheres = OcclusionMap::Spheres;
    Spheres spheres;
    SphereBlocks blocks;
    float towards[Spheres::kCapacity];
    size_t index[Spheres::kCapacity];
    for (size_t next = 0; next < surfaces.size();) {
        for (spheres.count = 0; next < surfaces.size() && spheres.count < Spheres::kCapacity; ++next) {
            const OcclusionMap::Surface& s = surfaces[next];
            const float leans = glm::dot(s.normal, s.centre);
            if (!(s.centre.z > kClearRadii * s.radius && s.centre.z - s.radius > grid.near && leans != 0))
                continue;
            towards[spheres.count] = leans, index[spheres.count] = next;
            spheres.add(s.centre, s.radius);
        }
        FindBlocks(grid, spheres, blocks);
        for (size_t i = 0; i < spheres.count; ++i)
            CoverBlocks(grid, surfaces[index[i]], towards[i], blocks, i, nearest);
    }
}

}  // namespace geom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace geom {

HWY_EXPORT(FindBlocks);
HWY_EXPORT(LookAt);
HWY_EXPORT(CoverAll);

void find_blocks(const BlockGrid& grid, const OcclusionMap::Spheres& spheres, SphereBlocks& blocks) {
    HWY_DYNAMIC_DISPATCH(FindBlocks)(grid, spheres, blocks);
}
void look_at(const BlockGrid& grid, const Covers& covers, const OcclusionMap::Spheres& spheres,
             Looked& looked) {
    HWY_DYNAMIC_DISPATCH(LookAt)(grid, covers, spheres, looked);
}
void cover_blocks(const BlockGrid& grid, std::span<const OcclusionMap::Surface> surfaces, float* nearest) {
    HWY_DYNAMIC_DISPATCH(CoverAll)(grid, surfaces, nearest);
}

}  // namespace geom
#endif
