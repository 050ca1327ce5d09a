#include "splat/disc.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/disc.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 8>;
using V = hn::Vec<D>;

void ViewFan(const Fan& fan, const Disc& disc, FanView* out) {
    const D d;
    struct Turned {
        V x, y, z;
    };
    const Frame& f = disc.frame;
    const float radius = disc.radius;
    const auto turn = [&](V x, V y, V z) {
        x = hn::Add(x, hn::Set(d, fan.vertex.x)), y = hn::Add(y, hn::Set(d, fan.vertex.y)), z = hn::Add(z, hn::Set(d, fan.vertex.z));
        const auto dot = [&](const glm::vec3& a) {
            return hn::Add(hn::Add(hn::Mul(x, hn::Set(d, a.x)), hn::Mul(y, hn::Set(d, a.y))), hn::Mul(z, hn::Set(d, a.z)));
        };
        return Turned{dot(f.t1), dot(f.t2), dot(f.n)};
    };
    const Turned v = turn(hn::Zero(d), hn::Zero(d), hn::Zero(d));
    const V zero = hn::Zero(d), r = hn::Set(d, radius), square = hn::Set(d, radius * radius * 1.0001f);
    V height = zero;
    *out = {false, 0, 0};
    for (size_t i = fan.begin; i < fan.end; i += hn::Lanes(d)) {
        const auto valid = hn::FirstN(d, fan.end - i);
        const Turned p = turn(hn::LoadU(d, &fan.p->x[i]), hn::LoadU(d, &fan.p->y[i]), hn::LoadU(d, &fan.p->z[i]));
        const Turned q = turn(hn::LoadU(d, &fan.q->x[i]), hn::LoadU(d, &fan.q->y[i]), hn::LoadU(d, &fan.q->z[i]));
        const V ax = hn::Sub(p.x, v.x), ay = hn::Sub(p.y, v.y), az = hn::Sub(p.z, v.z);
        const V bx = hn::Sub(q.x, v.x), by = hn::Sub(q.y, v.y), bz = hn::Sub(q.z, v.z);
        const V nx = hn::Sub(hn::Mul(ay, bz), hn::Mul(az, by)), ny = hn::Sub(hn::Mul(az, bx), hn::Mul(ax, bz)),
                nz = hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx));
        if (!hn::AllTrue(d, hn::Or(hn::Not(valid), hn::Gt(nz, zero)))) {
            out->is_folded = true;
            return;
        }
        const auto within = [&](const Turned& t) { return hn::Le(hn::Add(hn::Mul(t.x, t.x), hn::Mul(t.y, t.y)), square); };
        const auto cross = [&](const Turned& s, const Turned& t) { return hn::Sub(hn::Mul(s.x, t.y), hn::Mul(s.y, t.x)); };
        // Does the inner part of an edge come within the radius of 0?
        const auto passes = [&](const Turned& s, const Turned& t) {
            const V dx = hn::Sub(t.x, s.x), dy = hn::Sub(t.y, s.y);
            const V all = hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy));
            const V along = hn::Neg(hn::Add(hn::Mul(s.x, dx), hn::Mul(s.y, dy)));
            const V area = cross(s, t);
            return hn::And(hn::And(hn::Gt(along, zero), hn::Lt(along, all)), hn::Le(hn::Mul(area, area), hn::Mul(square, all)));
        };
        const auto crossing = hn::Or(passes(p, q), hn::Or(within(p), within(q)));
        const auto around = hn::And(hn::Ge(cross(v, p), zero), hn::And(hn::Ge(cross(p, q), zero), hn::Ge(cross(q, v), zero)));
        const auto meets = hn::And(valid, hn::Or(hn::Or(crossing, within(v)), hn::Or(around, hn::Or(passes(v, p), passes(q, v)))));
        // A face stays within its corners' heights, and within those of its plane in the radius.
        const V corners = hn::Max(hn::Abs(v.z), hn::Max(hn::Abs(p.z), hn::Abs(q.z)));
        const V middle = hn::Abs(hn::Add(hn::Add(hn::Mul(nx, v.x), hn::Mul(ny, v.y)), hn::Mul(nz, v.z)));
        const V slope = hn::Sqrt(hn::Add(hn::Mul(nx, nx), hn::Mul(ny, ny)));
        const V plane = hn::Div(hn::Add(middle, hn::Mul(slope, r)), nz);
        height = hn::Max(height, hn::IfThenElseZero(meets, hn::Min(corners, plane)));
        uint8_t bits[8] = {};
        hn::StoreMaskBits(d, hn::And(valid, crossing), bits);
        out->crossing |= uint64_t(bits[0]) << (i - fan.begin);
    }
    out->height = hn::GetLane(hn::MaxOfLanes(d, height));
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

// Largest distance of the disc's points from the nearest of `count` convex parts, each with its own error:
// cell by cell the part whose distance, at the cell's corners, is least.  distance(part, x, y) is from (x, y, 0).
template <class Distance, class Error>
HWY_INLINE float CellBound(float radius, size_t count, const Distance& distance, const Error& error_of) {
    static const Rings rings;
    const D d;
    float corner[kRings][kRing], bound[kRings][kSectors];
    for (auto& ring : bound) std::fill(ring, ring + kSectors, std::numeric_limits<float>::infinity());
    const int lanes = int(hn::Lanes(d));
    const V scale = hn::Set(d, radius);
    for (size_t part = 0; part < count; ++part) {
        for (int r = 0; r < kRings; ++r) {
            for (int k = 0; k < kSectors; k += lanes)
                hn::StoreU(distance(part, hn::Mul(scale, hn::LoadU(d, rings.x[r] + k)), hn::Mul(scale, hn::LoadU(d, rings.y[r] + k))), d, corner[r] + k);
            for (int k = 0; k < kRing - kSectors; k += lanes) hn::StoreU(hn::LoadU(d, corner[r] + k), d, corner[r] + kSectors + k);
        }
        const V error = hn::Set(d, error_of(part));
        const V middle = distance(part, hn::Zero(d), hn::Zero(d));
        for (int k = 0; k < kSectors; k += lanes) {
            V inner = middle;
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

float NestedError(float radius, const ChildShape* children, size_t count) {
    const D d;
    return CellBound(
        radius, count, [&](size_t c, V x, V y) { return DistanceToChild(d, x, y, children[c]); },
        [&](size_t c) { return children[c].error; });
}

// Distance from (px, py, 0) to the triangle a, b, c: to its plane where the foot is inside, else to the edges.
HWY_INLINE V DistanceToTriangle(D d, V px, V py, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const auto edge = [&](const glm::vec3& from, const glm::vec3& to) {
        const glm::vec3 e = to - from;
        const float square = glm::dot(e, e);
        const V x = hn::Sub(px, hn::Set(d, from.x)), y = hn::Sub(py, hn::Set(d, from.y)), z = hn::Set(d, -from.z);
        const V dot = hn::Add(hn::Add(hn::Mul(x, hn::Set(d, e.x)), hn::Mul(y, hn::Set(d, e.y))), hn::Mul(z, hn::Set(d, e.z)));
        const V t = hn::Min(one, hn::Max(zero, hn::Mul(dot, hn::Set(d, square > 0 ? 1.0f / square : 0.0f))));
        const V u = hn::Sub(x, hn::Mul(t, hn::Set(d, e.x))), v = hn::Sub(y, hn::Mul(t, hn::Set(d, e.y))),
                w = hn::Sub(z, hn::Mul(t, hn::Set(d, e.z)));
        return hn::Add(hn::Add(hn::Mul(u, u), hn::Mul(v, v)), hn::Mul(w, w));
    };
    const V edges = hn::Min(edge(a, b), hn::Min(edge(b, c), edge(c, a)));
    const glm::vec3 n = glm::cross(b - a, c - a);
    const float area = glm::dot(n, n);
    if (!(area > 0)) return hn::Sqrt(edges);
    const auto side = [&](const glm::vec3& from, const glm::vec3& to) {  // of the edge, in the plane
        const glm::vec3 m = glm::cross(n, to - from);
        const V x = hn::Sub(px, hn::Set(d, from.x)), y = hn::Sub(py, hn::Set(d, from.y));
        return hn::Ge(hn::Add(hn::Add(hn::Mul(x, hn::Set(d, m.x)), hn::Mul(y, hn::Set(d, m.y))), hn::Set(d, -from.z * m.z)), zero);
    };
    const auto inside = hn::And(side(a, b), hn::And(side(b, c), side(c, a)));
    const V x = hn::Sub(px, hn::Set(d, a.x)), y = hn::Sub(py, hn::Set(d, a.y));
    const V plane = hn::Add(hn::Add(hn::Mul(x, hn::Set(d, n.x)), hn::Mul(y, hn::Set(d, n.y))), hn::Set(d, -a.z * n.z));
    return hn::Sqrt(hn::IfThenElse(inside, hn::Mul(hn::Mul(plane, plane), hn::Set(d, 1.0f / area)), edges));
}

float FanError(const Fan& fan, const Disc& disc) {
    const D d;
    const auto turn = [&](const glm::vec3& p) {
        const glm::vec3 x = p + fan.vertex;
        return glm::vec3(glm::dot(disc.frame.t1, x), glm::dot(disc.frame.t2, x), glm::dot(disc.frame.n, x)) / disc.radius;  // of order 1: squares stay in range
    };
    const glm::vec3 v = turn(glm::vec3(0));
    glm::vec3 p[64], q[64];
    const size_t count = std::min<size_t>(fan.end - fan.begin, 64);
    for (size_t k = 0; k < count; ++k) p[k] = turn(fan.p->get(fan.begin + k)), q[k] = turn(fan.q->get(fan.begin + k));
    return disc.radius * CellBound(
        1.0f, count, [&](size_t k, V x, V y) { return DistanceToTriangle(d, x, y, v, p[k], q[k]); }, [](size_t) { return 0.0f; });
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(NestedError);
HWY_EXPORT(ViewFan);
HWY_EXPORT(FanError);

FanView view_fan(const Fan& fan, const Disc& disc) {
    FanView result;
    HWY_DYNAMIC_DISPATCH(ViewFan)(fan, disc, &result);
    return result;
}

float fan_error(const Fan& fan, const Disc& disc) { return HWY_DYNAMIC_DISPATCH(FanError)(fan, disc); }

float nested_error(float radius, std::span<const ChildShape> children) {
    return HWY_DYNAMIC_DISPATCH(NestedError)(radius, children.data(), children.size());
}

}  // namespace splat
#endif
