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

void Cover(const float* u, const float* v, const float* w, size_t count, const glm::vec3& c, float* out) {
    const D d;
    const V cu = hn::Set(d, c.x), cv = hn::Set(d, c.y), cw = hn::Set(d, c.z);
    V most[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    V weight[4];
    for (int k = 0; k < 4; ++k) weight[k] = hn::Set(d, 1.0f / (kFlatness[k] * kFlatness[k]));
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        const V du = hn::Sub(hn::LoadU(d, u + i), cu), dv = hn::Sub(hn::LoadU(d, v + i), cv),
                dw = hn::Sub(hn::LoadU(d, w + i), cw);
        const V across = hn::Add(hn::Mul(du, du), hn::Mul(dv, dv)), along = hn::Mul(dw, dw);
        for (int k = 0; k < 4; ++k) most[k] = hn::Max(most[k], hn::Add(across, hn::Mul(along, weight[k])));
    }
    for (int k = 0; k < 4; ++k) out[k] = hn::GetLane(hn::MaxOfLanes(d, most[k]));
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

// Corners of the cells on the unit disc: two rings of 12 directions, the outer one drawn round the
// circle; the first corners are repeated at the end, so that corner k + 1 can be loaded.
constexpr int kSectors = 12, kRing = 24;
struct Rings {
    float x[2][kRing], y[2][kRing];
    Rings() {
        const float outer = float(1.0001 / std::cos(3.14159265358979 / kSectors));
        for (int k = 0; k < kRing; ++k) {
            const double phi = 2 * 3.14159265358979 * (k % kSectors) / kSectors;
            x[0][k] = 0.55f * float(std::cos(phi)), y[0][k] = 0.55f * float(std::sin(phi));
            x[1][k] = outer * float(std::cos(phi)), y[1][k] = outer * float(std::sin(phi));
        }
    }
};

// Bound on the distance from (px, py, pz) to a child's ellipsoid: to the flat cylinder inside it
// of 0.9 radii, where it is still 0.43 half thicknesses thick either way.
template <class DD, class VV>
VV DistanceToChild(DD d, VV px, VV py, VV pz, const ChildShape& c) {
    const VV x = hn::Sub(px, hn::Set(d, c.centre.x)), y = hn::Sub(py, hn::Set(d, c.centre.y)),
             z = hn::Sub(pz, hn::Set(d, c.centre.z));
    const VV along = hn::Add(hn::Add(hn::Mul(x, hn::Set(d, c.normal.x)), hn::Mul(y, hn::Set(d, c.normal.y))),
                             hn::Mul(z, hn::Set(d, c.normal.z)));
    const VV all = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    const VV across = hn::Sqrt(hn::Max(hn::Zero(d), hn::Sub(all, hn::Mul(along, along))));
    const VV l = hn::Max(hn::Zero(d), hn::Sub(across, hn::Set(d, 0.9f * c.radius)));
    const VV h = hn::Max(hn::Zero(d), hn::Sub(hn::Abs(along), hn::Set(d, 0.43f * c.half_thickness)));
    return hn::Sqrt(hn::Add(hn::Mul(l, l), hn::Mul(h, h)));
}

float NestedError(float radius, float half_thickness, const ChildShape* children, size_t count) {
    static const Rings rings;
    const hn::CappedTag<float, 4> d;  // 12 sectors are three vectors of 4
    float inner[kRing], outer[kRing], bound_in[kSectors], bound_out[kSectors];
    for (int k = 0; k < kSectors; ++k) bound_in[k] = bound_out[k] = std::numeric_limits<float>::infinity();
    const auto lanes = int(hn::Lanes(d));
    const auto up = hn::Set(d, half_thickness), down = hn::Neg(up), scale = hn::Set(d, radius);
    for (size_t c = 0; c < count; ++c) {
        const auto both = [&](auto px, auto py) {
            return hn::Max(DistanceToChild(d, px, py, up, children[c]), DistanceToChild(d, px, py, down, children[c]));
        };
        for (int k = 0; k < kSectors + 4; k += lanes) {
            hn::StoreU(both(hn::Mul(scale, hn::LoadU(d, rings.x[0] + k)), hn::Mul(scale, hn::LoadU(d, rings.y[0] + k))), d, inner + k);
            hn::StoreU(both(hn::Mul(scale, hn::LoadU(d, rings.x[1] + k)), hn::Mul(scale, hn::LoadU(d, rings.y[1] + k))), d, outer + k);
        }
        const auto middle = hn::Set(d, hn::GetLane(both(hn::Zero(d), hn::Zero(d))));
        const auto error = hn::Set(d, children[c].error);
        for (int k = 0; k < kSectors; k += lanes) {
            const auto in = hn::Max(hn::LoadU(d, inner + k), hn::LoadU(d, inner + k + 1));
            const auto out = hn::Max(hn::LoadU(d, outer + k), hn::LoadU(d, outer + k + 1));
            hn::StoreU(hn::Min(hn::LoadU(d, bound_in + k), hn::Add(error, hn::Max(in, middle))), d, bound_in + k);
            hn::StoreU(hn::Min(hn::LoadU(d, bound_out + k), hn::Add(error, hn::Max(in, out))), d, bound_out + k);
        }
    }
    return std::max(*std::max_element(bound_in, bound_in + kSectors), *std::max_element(bound_out, bound_out + kSectors));
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

std::array<float, 4> cover(const FramePoints& points, const glm::vec3& centre) {
    std::array<float, 4> result;
    HWY_DYNAMIC_DISPATCH(Cover)(points.u.data(), points.v.data(), points.w.data(), points.count, centre, result.data());
    return result;
}

float least_dot(const PointArrays& vectors, size_t begin, size_t end, const glm::vec3& normal) {
    return HWY_DYNAMIC_DISPATCH(LeastDot)(vectors.x.data() + begin, vectors.y.data() + begin, vectors.z.data() + begin,
                                          end - begin, normal);
}

float nested_error(float radius, float half_thickness, std::span<const ChildShape> children) {
    return HWY_DYNAMIC_DISPATCH(NestedError)(radius, half_thickness, children.data(), children.size());
}

}  // namespace splat
#endif
