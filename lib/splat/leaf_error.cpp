#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/disc.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/leaf_error.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/cells-inl.h"
#include "splat/vector3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kSpare>;  // a face or an edge a lane
using V = hn::Vec<D>;
using V3 = Vector3<V>;

// All of what follows is in a disc's frame: the disc is about 0, across z.

HWY_INLINE V Cross(V ax, V ay, V bx, V by) {
    return hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx));
}
HWY_INLINE V SquareFromAxis(const V3& p) {
    return hn::Add(hn::Mul(p.x, p.x), hn::Mul(p.y, p.y));
}

// Square of the distance of the edges from s to t from the axis.
HWY_INLINE V SquareFromAxis(const V3& s, const V3& t) {
    const D d;
    const V zero = hn::Zero(d), dx = hn::Sub(t.x, s.x), dy = hn::Sub(t.y, s.y);
    const V all = hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy));
    const V along = hn::Neg(hn::Add(hn::Mul(s.x, dx), hn::Mul(s.y, dy)));
    const V at =
        hn::Min(hn::Set(d, 1.0f), hn::Max(zero, hn::IfThenElseZero(hn::Gt(all, zero), hn::Div(along, all))));
    const V x = hn::Add(s.x, hn::Mul(at, dx)), y = hn::Add(s.y, hn::Mul(at, dy));
    return hn::Add(hn::Mul(x, x), hn::Mul(y, y));
}

// How far up or down the edges from s to t go over the disc whose radius has this square.
HWY_INLINE V HeightOfEdge(const V3& s, const V3& t, V square) {
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const V dx = hn::Sub(t.x, s.x), dy = hn::Sub(t.y, s.y), dz = hn::Sub(t.z, s.z);
    const V inverse = hn::Div(one, hn::Max(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)),
                                           hn::Set(d, std::numeric_limits<float>::min())));
    const V middle = hn::Mul(hn::Neg(hn::Add(hn::Mul(s.x, dx), hn::Mul(s.y, dy))), inverse);
    const V area = Cross(s.x, s.y, t.x, t.y);
    const V left = hn::Sub(square, hn::Mul(hn::Mul(area, area), inverse));
    const V half = hn::Sqrt(hn::Mul(hn::Max(left, zero), inverse));
    const V first = hn::Max(zero, hn::Sub(middle, half)), last = hn::Min(one, hn::Add(middle, half));
    const V most =
        hn::Max(hn::Abs(hn::Add(s.z, hn::Mul(first, dz))), hn::Abs(hn::Add(s.z, hn::Mul(last, dz))));
    return hn::IfThenElseZero(hn::And(hn::Ge(left, zero), hn::Le(first, last)), most);
}

// How far up or down the faces' planes go at the rim of that disc, where it is over the face.
HWY_INLINE V HeightAtRim(const V3& v, const V3& p, const V3& q, V square) {
    const D d;
    const V3 a{hn::Sub(p.x, v.x), hn::Sub(p.y, v.y), hn::Sub(p.z, v.z)},
        b{hn::Sub(q.x, v.x), hn::Sub(q.y, v.y), hn::Sub(q.z, v.z)};
    const V3 n{Cross(a.y, a.z, b.y, b.z), Cross(a.z, a.x, b.z, b.x), Cross(a.x, a.y, b.x, b.y)};
    const V slope2 = SquareFromAxis(n);
    const V outwards =
        hn::Sqrt(hn::Div(square, hn::Max(slope2, hn::Set(d, std::numeric_limits<float>::min()))));
    const V middle = Dot(n, v), tolerance = hn::Mul(square, hn::Set(d, -1e-5f)),
            inverse = hn::Div(hn::Set(d, 1.0f), n.z);
    const auto at_rim = [&](V to) {
        const V x = hn::Mul(n.x, to), y = hn::Mul(n.y, to);
        const auto side = [&](const V3& s, const V3& t) {
            return hn::Ge(Cross(hn::Sub(s.x, x), hn::Sub(s.y, y), hn::Sub(t.x, x), hn::Sub(t.y, y)),
                          tolerance);
        };
        const V most = hn::Abs(hn::Mul(hn::Sub(middle, hn::Mul(to, slope2)), inverse));
        return hn::IfThenElseZero(hn::And(side(v, p), hn::And(side(p, q), side(q, v))), most);
    };
    return hn::Max(at_rim(outwards), at_rim(hn::Neg(outwards)));
}

// Edges of a patch that cross the disc and have no face on their other side, as their faces have them.
struct Rim {
    static constexpr size_t kMost = 128;
    static constexpr uint64_t kNone = ~uint64_t(0);

    size_t count = 0;
    uint64_t edge[kMost];  // corners' numbers: from << 32 | to
    alignas(64) float from[3][kMost + kSpare], to[3][kMost + kSpare];

    static uint64_t edge_of(uint32_t from, uint32_t to) { return uint64_t(from) << 32 | to; }
    void add(uint64_t numbers, const glm::vec3& s, const glm::vec3& t) {
        edge[count] = numbers;
        for (int axis = 0; axis < 3; ++axis) from[axis][count] = s[axis], to[axis][count] = t[axis];
        ++count;
    }
    void move(size_t i, size_t to_place) {
        edge[to_place] = edge[i];
        for (int axis = 0; axis < 3; ++axis)
            from[axis][to_place] = from[axis][i], to[axis][to_place] = to[axis][i];
    }
    V3 load_from(size_t i) const { return load(from, i); }
    V3 load_to(size_t i) const { return load(to, i); }

  private:
    static V3 load(const float (&points)[3][kMost + kSpare], size_t i) {
        const D d;
        return {hn::Load(d, points[0] + i), hn::Load(d, points[1] + i), hn::Load(d, points[2] + i)};
    }
};

// Strikes out one edge with these numbers.  False where there is none.
bool StrikeOut(uint64_t* edges, size_t count, uint64_t numbers) {
    uint64_t* const at = std::find(edges, edges + count, numbers);
    if (at == edges + count) return false;
    *at = Rim::kNone;
    return true;
}

// Some corners' numbers; says no only where it is sure.
class CornerFilter {
  public:
    void add(uint32_t corner) { words_[corner / 64 % 4] |= uint64_t(1) << corner % 64; }
    bool may_have(uint32_t corner) const { return words_[corner / 64 % 4] >> corner % 64 & 1; }

  private:
    uint64_t words_[4] = {};
};

// Some faces about a leaf, turned into its disc's frame, and their rim.
class Patch {
  public:
    static constexpr size_t kMost = 64;

    Patch(const Surface& surface, const glm::dvec3& centre, const Disc& disc)
        : surface_(surface), centre_(centre), disc_(disc), square_(disc.radius * disc.radius * 1.0001f) {}

    // Takes the faces about a leaf.  False where one of them is not seen from the normal's side.
    bool take_fan(uint32_t leaf) {
        const D d;
        const uint32_t begin = surface_.fan_begin[leaf], end = surface_.fan_begin[leaf + 1];
        const glm::vec3 vertex = turned(leaf);
        const auto turn = [&](const PointArrays& points, size_t i) {
            const V3 p{hn::LoadU(d, &points.x[i]), hn::LoadU(d, &points.y[i]), hn::LoadU(d, &points.z[i])};
            return V3{hn::Add(Dot(Set3(d, disc_.frame.t1), p), hn::Set(d, vertex.x)),
                      hn::Add(Dot(Set3(d, disc_.frame.t2), p), hn::Set(d, vertex.y)),
                      hn::Add(Dot(Set3(d, disc_.frame.n), p), hn::Set(d, vertex.z))};
        };
        for (uint32_t i = begin; i < end; i += uint32_t(hn::Lanes(d))) {
            const V3 p = turn(surface_.fan_p, i), q = turn(surface_.fan_q, i);
            store(Set3(d, vertex), at_[0], i - begin), store(p, at_[1], i - begin),
                store(q, at_[2], i - begin);
            store(p, rim().from, i - begin), store(q, rim().to, i - begin);
        }
        count_ = fan_count_ = rim().count = end - begin;
        for (uint32_t k = 0; k < count_; ++k) {
            const glm::u32vec2 face = surface_.fan[begin + k];
            rim().edge[k] = Rim::edge_of(face.x, face.y);
            hwy::Prefetch(&surface_.fan[surface_.fan_begin[face.x]]);  // nearly all rims are crossed
        }
        keep_crossing(rim());
        return is_facing(0);
    }

    // Adds the faces beyond the rim.  False, and nothing is added, where one of them is not there, or is not
    // seen from the normal's side, or there are too many.
    HWY_NOINLINE bool grow() {
        const size_t first = count_;
        const Rim& old = rim();
        Rim& next = rims_[1 - now_];
        next.count = 0;
        uint64_t waiting[Rim::kMost];
        std::copy_n(old.edge, old.count, waiting);
        CornerFilter corners;
        for (size_t k = 0; k < old.count; ++k)
            corners.add(uint32_t(old.edge[k] >> 32)), corners.add(uint32_t(old.edge[k]));
        bool is_grown = true;
        for (size_t k = 0; k < old.count && is_grown; ++k)
            if (waiting[k] != Rim::kNone) is_grown = add_beyond(old, k, waiting, next, corners);
        if (!is_grown || !is_facing(first)) {
            count_ = first;
            return false;
        }
        keep_crossing(next);
        now_ = 1 - now_;
        return true;
    }

    bool is_whole() const { return rim().count == 0; }

    // No face goes further up or down over the disc.
    float height() {
        const D d;
        for (; measured_ < count_; measured_ = std::min(count_, measured_ + hn::Lanes(d))) measure(measured_);
        return height_;
    }

    // Bound on the distance of the disc's points beyond the rim from it: on the way out from the disc's
    // centre, which is over a face, they have passed it.  After height().
    HWY_NOINLINE float overhang() const {
        const D d;
        if (!is_over_centre_) return std::numeric_limits<float>::infinity();
        V most = hn::Zero(d);
        for (size_t i = 0; i < rim().count; i += hn::Lanes(d)) {
            const V3 s = rim().load_from(i), t = rim().load_to(i);
            const V beyond =
                hn::Max(hn::Zero(d), hn::Sub(hn::Set(d, disc_.radius), hn::Sqrt(SquareFromAxis(s, t))));
            const V off = hn::Max(hn::Abs(s.z), hn::Abs(t.z));
            const V square = hn::Add(hn::Mul(beyond, beyond), hn::Mul(off, off));
            most = hn::Max(most, hn::IfThenElseZero(hn::FirstN(d, rim().count - i), square));
        }
        return std::sqrt(hn::GetLane(hn::MaxOfLanes(d, most)));
    }

  private:
    static constexpr uint32_t kNone = ~0u;
    using Row = float[kMost + kSpare];

    template <size_t N>
    static void store(const V3& p, float (&to)[3][N], size_t i) {
        const D d;
        hn::StoreU(p.x, d, to[0] + i), hn::StoreU(p.y, d, to[1] + i), hn::StoreU(p.z, d, to[2] + i);
    }
    V3 load(size_t corner, size_t i) const {
        const D d;
        return {hn::LoadU(d, at_[corner][0] + i), hn::LoadU(d, at_[corner][1] + i),
                hn::LoadU(d, at_[corner][2] + i)};
    }

    Rim& rim() { return rims_[now_]; }
    const Rim& rim() const { return rims_[now_]; }

    glm::vec3 turned(uint32_t corner) const {
        const glm::vec3 p(surface_.at[corner] - centre_);
        return {glm::dot(disc_.frame.t1, p), glm::dot(disc_.frame.t2, p), glm::dot(disc_.frame.n, p)};
    }

    // Adds the face that has edge k of a rim the other way round.  Its other edges meet their reverse among
    // those that wait for it, or become part of the next rim.
    bool add_beyond(const Rim& old, size_t k, uint64_t* waiting, Rim& next, CornerFilter& corners) {
        const auto from = uint32_t(old.edge[k] >> 32), to = uint32_t(old.edge[k]);
        const uint32_t third = beyond(from, to);
        if (third == kNone || count_ == kMost) return false;
        const glm::vec3 s{old.from[0][k], old.from[1][k], old.from[2][k]},
            t{old.to[0][k], old.to[1][k], old.to[2][k]}, at = turned(third);
        for (int axis = 0; axis < 3; ++axis)
            at_[0][axis][count_] = t[axis], at_[1][axis][count_] = s[axis], at_[2][axis][count_] = at[axis];
        ++count_;
        const bool is_new = !corners.may_have(third);
        const auto join = [&](uint32_t a, uint32_t b, const glm::vec3& at_a, const glm::vec3& at_b) {
            const uint64_t reverse = Rim::edge_of(b, a);
            if (is_new ||
                (!StrikeOut(waiting, old.count, reverse) && !StrikeOut(next.edge, next.count, reverse)))
                next.add(Rim::edge_of(a, b), at_a, at_b);
        };
        join(from, third, s, at), join(third, to, at, t);
        corners.add(third);
        return true;
    }

    // The third corner of the face that has an edge the other way round: about the corner where the edge
    // begins, its p where q is the edge's end; about the corner where it ends, its q where p is the edge's
    // beginning.
    uint32_t beyond(uint32_t from, uint32_t to) const {
        const uint32_t third = partner(from, to, 0xaaaau);
        return third != kNone ? third : partner(to, from, 0x5555u);
    }

    // The other corner of the face about a corner that has `corner` where the bits of the mask are set.
    uint32_t partner(uint32_t about, uint32_t corner, uint32_t mask) const {
        const hn::CappedTag<uint32_t, kSpare> d;
        const uint32_t begin = surface_.fan_begin[about], numbers = 2 * surface_.valence(about);
        const uint32_t* const fan = &surface_.fan[begin].x;
        for (uint32_t at = 0; at < numbers; at += uint32_t(hn::Lanes(d))) {
            const auto same =
                hn::And(hn::FirstN(d, numbers - at), hn::Eq(hn::LoadU(d, fan + at), hn::Set(d, corner)));
            if (const uint32_t found = bits_of(d, same) & mask)
                return fan[(at + unsigned(__builtin_ctz(found))) ^ 1u];
        }
        return kNone;
    }

    template <class Tag, class Mask>
    static uint32_t bits_of(Tag d, Mask mask) {
        uint8_t bits[8] = {};
        hn::StoreMaskBits(d, mask, bits);
        return uint32_t(bits[1]) << 8 | bits[0];
    }

    // Are the faces from `first` on seen from the normal's side?
    HWY_NOINLINE bool is_facing(size_t first) const {
        const D d;
        for (size_t i = first; i < count_; i += hn::Lanes(d)) {
            const V3 v = load(0, i), p = load(1, i), q = load(2, i);
            const V area = Cross(hn::Sub(p.x, v.x), hn::Sub(p.y, v.y), hn::Sub(q.x, v.x), hn::Sub(q.y, v.y));
            if (!hn::AllTrue(d, hn::Or(hn::Not(hn::FirstN(d, count_ - i)), hn::Gt(area, hn::Zero(d)))))
                return false;
        }
        return true;
    }

    // Drops the edges of a rim that do not cross the disc, and those that were struck out.
    HWY_NOINLINE void keep_crossing(Rim& rim) const {
        const D d;
        size_t kept = 0;
        for (size_t i = 0; i < rim.count; i += hn::Lanes(d)) {
            const auto crossing =
                hn::Le(SquareFromAxis(rim.load_from(i), rim.load_to(i)), hn::Set(d, square_));
            for (uint32_t bits = bits_of(d, hn::And(hn::FirstN(d, rim.count - i), crossing)); bits;
                 bits &= bits - 1) {
                const size_t at = i + unsigned(__builtin_ctz(bits));
                if (rim.edge[at] != Rim::kNone) rim.move(at, kept++);
            }
        }
        rim.count = kept;
    }

    // Highest and lowest a face is where its edges enter or leave the disc or end in it, or where the rim is
    // furthest up or down its plane.  The disc is taken larger by what rounding may do.  An edge is seen from
    // one of its faces: that to the first corner of a face that was added is one of the rim's before, and
    // that from the third corner of a face of the fan is the next one's.
    void measure(size_t first) {
        const D d;
        const V3 v = load(0, first), p = load(1, first), q = load(2, first);
        const auto valid = hn::FirstN(d, count_ - first);
        const auto is_fan = hn::FirstN(d, fan_count_ - std::min(first, fan_count_));
        const V most_square = hn::Max(SquareFromAxis(v), hn::Max(SquareFromAxis(p), SquareFromAxis(q)));
        const V reach = hn::Add(hn::Set(d, square_), hn::Mul(most_square, hn::Set(d, 1e-6f)));
        const auto pick = [&](V a, V b) { return hn::IfThenElse(is_fan, a, b); };
        const V3 s{pick(v.x, q.x), pick(v.y, q.y), pick(v.z, q.z)},
            t{pick(p.x, v.x), pick(p.y, v.y), pick(p.z, v.z)};
        const V edges = hn::Max(HeightOfEdge(p, q, reach), HeightOfEdge(s, t, reach));
        const V corners = hn::Max(hn::Abs(v.z), hn::Max(hn::Abs(p.z), hn::Abs(q.z)));
        const V height = hn::Min(corners, hn::Max(edges, HeightAtRim(v, p, q, reach)));
        height_ = std::max(height_, hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(valid, height))));
        const auto is_left = [&](const V3& a, const V3& b) {
            return hn::Ge(Cross(a.x, a.y, b.x, b.y), hn::Zero(d));
        };
        is_over_centre_ |=
            !hn::AllFalse(d, hn::And(valid, hn::And(is_left(v, p), hn::And(is_left(p, q), is_left(q, v)))));
    }

    const Surface& surface_;
    const glm::dvec3 centre_;
    const Disc& disc_;
    const float square_;                // of the radius
    size_t count_ = 0, fan_count_ = 0;  // faces; those about the leaf come first
    size_t measured_ = 0;
    alignas(64) Row at_[3][3];  // corner, axis, face
    Rim rims_[2];
    int now_ = 0;
    float height_ = 0;
    bool is_over_centre_ = false;
};

// Distance from (px, py, 0) to the triangle a, b, c: to its plane where the foot is inside, else to the
// edges.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V DistanceToTriangle(D d, V px, V py, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const auto edge = [&](const glm::vec3& from, const glm::vec3& to) {
        const glm::vec3 e = to - from;
        const float square = glm::dot(e, e);
        const V x = hn::Sub(px, hn::Set(d, from.x)), y = hn::Sub(py, hn::Set(d, from.y)),
                z = hn::Set(d, -from.z);
        const V dot = hn::Add(hn::Add(hn::Mul(x, hn::Set(d, e.x)), hn::Mul(y, hn::Set(d, e.y))),
                              hn::Mul(z, hn::Set(d, e.z)));
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
        return hn::Ge(hn::Add(hn::Add(hn::Mul(x, hn::Set(d, m.x)), hn::Mul(y, hn::Set(d, m.y))),
                              hn::Set(d, -from.z * m.z)),
                      zero);
    };
    const auto inside = hn::And(side(a, b), hn::And(side(b, c), side(c, a)));
    const V x = hn::Sub(px, hn::Set(d, a.x)), y = hn::Sub(py, hn::Set(d, a.y));
    const V plane =
        hn::Add(hn::Add(hn::Mul(x, hn::Set(d, n.x)), hn::Mul(y, hn::Set(d, n.y))), hn::Set(d, -a.z * n.z));
    return hn::Sqrt(hn::IfThenElse(inside, hn::Mul(hn::Mul(plane, plane), hn::Set(d, 1.0f / area)), edges));
}

// Bound on the distance of the disc's points from the faces about the leaf and about its neighbours that are
// not far from the disc (of more than kMost, the first ones).
HWY_NOINLINE float NearFacesError(const Surface& surface, uint32_t leaf, const glm::dvec3& centre,
                                  const Disc& disc) {
    constexpr size_t kMost = 256;
    const auto turned = [&](uint32_t corner) {
        const glm::vec3 x(surface.at[corner] - centre);
        return glm::vec3(glm::dot(disc.frame.t1, x), glm::dot(disc.frame.t2, x), glm::dot(disc.frame.n, x)) /
               disc.radius;  // of order 1: squares stay in range
    };
    uint32_t pivots[kMost] = {leaf};
    size_t count = 1;
    const auto is_among = [&](uint32_t corner, size_t first) {
        return std::find(pivots, pivots + first, corner) != pivots + first;
    };
    for (uint32_t k = surface.fan_begin[leaf]; k < surface.fan_begin[leaf + 1]; ++k)
        for (const uint32_t corner : {surface.fan[k].x, surface.fan[k].y})
            if (count < kMost && !is_among(corner, count) && glm::length(turned(corner)) < 2)
                pivots[count++] = corner;
    glm::vec3 v[kMost], p[kMost], q[kMost];
    size_t taken = 0;
    for (size_t n = 0; n < count; ++n)
        for (uint32_t k = surface.fan_begin[pivots[n]]; k < surface.fan_begin[pivots[n] + 1] && taken < kMost;
             ++k) {
            const glm::u32vec2 face = surface.fan[k];
            if (is_among(face.x, n) || is_among(face.y, n)) continue;
            v[taken] = turned(pivots[n]), p[taken] = turned(face.x), q[taken] = turned(face.y);
            ++taken;
        }
    const auto distance = [&](size_t k, auto x, auto y) {
        return DistanceToTriangle(Sectors(), x, y, v[k], p[k], q[k]);
    };
    const auto error = [](size_t) { return 0.0f; };
    return disc.radius * Cells(1.0f, taken, distance, error).fine_bound(kErrorOfRadius[disc.flatness][0]);
}

// The faces about the leaf are taken, and then those beyond their rim, until no edge of the rim crosses the
// disc.  If all of them are seen from the normal's side, their projection covers the whole disc (its degree
// over the disc is constant, and positive at the vertex), so that over each point of the disc there is
// surface, no further up or down than the faces that meet the disc go.  Where they fold over or end, it is
// the distance to the faces near it.
float LeafError(const Surface& surface, uint32_t leaf, const glm::dvec3& centre, const Disc& disc) {
    if (!surface.is_closed[leaf] || surface.valence(leaf) > Patch::kMost / 2)
        return NearFacesError(surface, leaf, centre, disc);
    Patch patch(surface, centre, disc);
    if (!patch.take_fan(leaf)) return NearFacesError(surface, leaf, centre, disc);
    const auto code = [&](float error) { return encode_error(error, disc.radius, disc.flatness); };
    for (bool is_fan = true; !patch.is_whole(); is_fan = false) {
        // Faces further out matter only where they make the code smaller.  The first ones beyond the fan
        // nearly always do.
        if (!is_fan) {
            const float height = patch.height(), bound = std::max(height, patch.overhang());
            if (code(bound) == code(height)) return bound;
        }
        if (!patch.grow()) {
            const float height = patch.height();
            return std::min(std::max(height, patch.overhang()), NearFacesError(surface, leaf, centre, disc));
        }
    }
    return patch.height();
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(LeafError);

float leaf_error(const Surface& surface, uint32_t leaf, const glm::dvec3& centre, const Disc& disc) {
    return HWY_DYNAMIC_DISPATCH(LeafError)(surface, leaf, centre, disc);
}

}  // namespace splat
#endif
