#include "splat/cover.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cover.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kLanes>;
using V = hn::Vec<D>;

void Rotate(const float* x, const float* y, const float* z, size_t count, const glm::vec3& base, const Frame& f,
            float* u, float* v, float* w, Extent* extent) {
    const D d;
    const V bx = hn::Set(d, base.x), by = hn::Set(d, base.y), bz = hn::Set(d, base.z);
    V low[5], high[5];
    for (int k = 0; k < 5; ++k)
        low[k] = hn::Set(d, std::numeric_limits<float>::infinity()), high[k] = hn::Neg(low[k]);
    const auto dot = [&](const glm::vec3& a, V px, V py, V pz) {
        return hn::Add(hn::Add(hn::Mul(hn::Set(d, a.x), px), hn::Mul(hn::Set(d, a.y), py)), hn::Mul(hn::Set(d, a.z), pz));
    };
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        const V px = hn::Sub(hn::LoadU(d, x + i), bx), py = hn::Sub(hn::LoadU(d, y + i), by),
                pz = hn::Sub(hn::LoadU(d, z + i), bz);
        const V pu = dot(f.t1, px, py, pz), pv = dot(f.t2, px, py, pz), pw = dot(f.n, px, py, pz);
        hn::StoreU(pu, d, u + i), hn::StoreU(pv, d, v + i), hn::StoreU(pw, d, w + i);
        const V along[5] = {pu, pv, pw, hn::Add(pu, pv), hn::Sub(pu, pv)};
        for (int k = 0; k < 5; ++k) low[k] = hn::Min(low[k], along[k]), high[k] = hn::Max(high[k], along[k]);
    }
    for (int k = 0; k < 5; ++k) {
        extent->low[k] = hn::GetLane(hn::MinOfLanes(d, low[k]));
        extent->high[k] = hn::GetLane(hn::MaxOfLanes(d, high[k]));
    }
}

// A lane a centre; the points one by one.
void Cover(const float* u, const float* v, const float* w, size_t count, const Centres& centres, Cover8* out) {
    const D d;
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
        const V cu = hn::LoadU(d, centres.u + lane), cv = hn::LoadU(d, centres.v + lane), cw = hn::LoadU(d, centres.w + lane);
        V most0 = hn::Zero(d), most1 = hn::Zero(d), most2 = hn::Zero(d), most3 = hn::Zero(d);
        const V weight0 = hn::Set(d, 1.0f / (kFlatness[0] * kFlatness[0])), weight1 = hn::Set(d, 1.0f / (kFlatness[1] * kFlatness[1])),
                weight2 = hn::Set(d, 1.0f / (kFlatness[2] * kFlatness[2]));
        for (size_t i = 0; i < count; ++i) {
            const V du = hn::Sub(hn::Set(d, u[i]), cu), dv = hn::Sub(hn::Set(d, v[i]), cv), dw = hn::Sub(hn::Set(d, w[i]), cw);
            const V across = hn::Add(hn::Mul(du, du), hn::Mul(dv, dv)), along = hn::Mul(dw, dw);
            most0 = hn::Max(most0, hn::Add(across, hn::Mul(along, weight0)));
            most1 = hn::Max(most1, hn::Add(across, hn::Mul(along, weight1)));
            most2 = hn::Max(most2, hn::Add(across, hn::Mul(along, weight2)));
            most3 = hn::Max(most3, hn::Add(across, along));
        }
        hn::StoreU(most0, d, out->square[0] + lane), hn::StoreU(most1, d, out->square[1] + lane);
        hn::StoreU(most2, d, out->square[2] + lane), hn::StoreU(most3, d, out->square[3] + lane);
    }
}

float LeastDot(const float* x, const float* y, const float* z, size_t count, const glm::vec3& n) {
    const D d;
    const V nx = hn::Set(d, n.x), ny = hn::Set(d, n.y), nz = hn::Set(d, n.z);
    V least = hn::Set(d, 1.0f);
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        const V dot = hn::Add(hn::Add(hn::Mul(nx, hn::LoadU(d, x + i)), hn::Mul(ny, hn::LoadU(d, y + i))),
                              hn::Mul(nz, hn::LoadU(d, z + i)));
        least = hn::Min(least, dot);
    }
    return hn::GetLane(hn::MinOfLanes(d, least));
}

// Corners of the cells on the unit disc: the centre, and three rings of 16, the outermost drawn round the
// circle.  The first corner of each ring is repeated at its end, so that corner k + 1 can be loaded.
constexpr int kSectors = 16, kRing = kSectors + 8, kRings = 3;
struct Rings {
    float x[kRings][kRing], y[kRings][kRing];
    Rings() {
        const double radius[kRings] = {0.4, 0.72, 1.0001 / std::cos(3.14159265358979 / kSectors)};
        for (int r = 0; r < kRings; ++r)
            for (int k = 0; k < kRing; ++k) {
                const double phi = 2 * 3.14159265358979 * (k % kSectors) / kSectors;
                x[r][k] = float(radius[r] * std::cos(phi)), y[r][k] = float(radius[r] * std::sin(phi));
            }
    }
};

// Distance from (px, py, 0) to a child's disc.
HWY_INLINE V DistanceToChild(D d, V px, V py, const ChildShape& c) {
    const V x = hn::Sub(px, hn::Set(d, c.centre.x)), y = hn::Sub(py, hn::Set(d, c.centre.y)), z = hn::Set(d, -c.centre.z);
    const V along = hn::Add(hn::Add(hn::Mul(x, hn::Set(d, c.normal.x)), hn::Mul(y, hn::Set(d, c.normal.y))),
                            hn::Mul(z, hn::Set(d, c.normal.z)));
    const V square = hn::Mul(along, along);
    const V all = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    const V across = hn::Sqrt(hn::Max(hn::Zero(d), hn::Sub(all, square)));
    const V beyond = hn::Max(hn::Zero(d), hn::Sub(across, hn::Set(d, c.radius)));
    return hn::Sqrt(hn::Add(hn::Mul(beyond, beyond), square));
}

float NestedError(float radius, const ChildShape* children, size_t count) {
    static const Rings rings;
    const D d;
    float corner[kRings][kRing], bound[kRings][kSectors];
    for (auto& ring : bound) std::fill(ring, ring + kSectors, std::numeric_limits<float>::infinity());
    const int lanes = int(hn::Lanes(d));
    const V scale = hn::Set(d, radius);
    for (size_t c = 0; c < count; ++c) {
        for (int r = 0; r < kRings; ++r)
            for (int k = 0; k < kRing; k += lanes)
                hn::StoreU(DistanceToChild(d, hn::Mul(scale, hn::LoadU(d, rings.x[r] + k)), hn::Mul(scale, hn::LoadU(d, rings.y[r] + k)), children[c]), d,
                           corner[r] + k);
        const V error = hn::Set(d, children[c].error);
        for (int k = 0; k < kSectors; k += lanes) {
            V inner = DistanceToChild(d, hn::Zero(d), hn::Zero(d), children[c]);
            for (int r = 0; r < kRings; ++r) {
                const V outer = hn::Max(hn::LoadU(d, corner[r] + k), hn::LoadU(d, corner[r] + k + 1));
                hn::StoreU(hn::Min(hn::LoadU(d, bound[r] + k), hn::Add(error, hn::Max(inner, outer))), d, bound[r] + k);
                inner = outer;
            }
        }
    }
    float worst = 0;
    for (const auto& ring : bound) worst = std::max(worst, *std::max_element(ring, ring + kSectors));
    return worst;
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(Rotate);
HWY_EXPORT(Cover);
HWY_EXPORT(LeastDot);
HWY_EXPORT(NestedError);

Extent rotate(const PointArrays& points, size_t begin, size_t end, const glm::vec3& base, const Frame& frame,
              FramePoints& out) {
    out.count = end - begin;
    if (out.u.size() < out.count) out.u.resize(out.count), out.v.resize(out.count), out.w.resize(out.count);
    Extent extent;
    HWY_DYNAMIC_DISPATCH(Rotate)(points.x.data() + begin, points.y.data() + begin, points.z.data() + begin, out.count, base,
                                 frame, out.u.data(), out.v.data(), out.w.data(), &extent);
    return extent;
}

Cover8 cover(const FramePoints& points, const Centres& centres) {
    Cover8 result;
    HWY_DYNAMIC_DISPATCH(Cover)(points.u.data(), points.v.data(), points.w.data(), points.count, centres, &result);
    return result;
}

float least_dot(const PointArrays& vectors, size_t begin, size_t end, const glm::vec3& normal) {
    return HWY_DYNAMIC_DISPATCH(LeastDot)(vectors.x.data() + begin, vectors.y.data() + begin, vectors.z.data() + begin,
                                          end - begin, normal);
}

float nested_error(float radius, std::span<const ChildShape> children) {
    return HWY_DYNAMIC_DISPATCH(NestedError)(radius, children.data(), children.size());
}

}  // namespace splat
#endif
