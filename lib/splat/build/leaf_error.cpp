#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/build/disc.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/build/leaf_error.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/pack-inl.h"
#include "splat/build/cells-inl.h"
#include "splat/vector3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using core::HWY_NAMESPACE::Pack;

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

// Where edges from s to t are over the disc whose radius has this square, and how far up or down they go
// there.
struct Crossing {
    hn::Mask<D> is_over;
    V height;
};
HWY_INLINE Crossing CrossingOf(const V3& s, const V3& t, V square) {
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
    return {hn::And(hn::Ge(left, zero), hn::Le(first, last)), most};
}
HWY_INLINE V HeightOf(const Crossing& crossing) {
    return hn::IfThenElseZero(crossing.is_over, crossing.height);
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

template <class Tag, class Mask>
uint32_t BitsOf(Tag d, Mask mask) {
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, mask, bits);
    return uint32_t(bits[1]) << 8 | bits[0];
}

// Some faces by their corners, a lane a face.
template <size_t kRoom, size_t kCorners = 3>
struct Corners {
    alignas(64) float at[kCorners][3][kRoom];  // corner, axis, face
    void store(size_t corner, size_t i, const V3& p) {
        const D d;
        hn::StoreU(p.x, d, &at[corner][0][i]), hn::StoreU(p.y, d, &at[corner][1][i]),
            hn::StoreU(p.z, d, &at[corner][2][i]);
    }
    V3 load(size_t corner, size_t i) const {
        const D d;
        return {hn::LoadU(d, &at[corner][0][i]), hn::LoadU(d, &at[corner][1][i]),
                hn::LoadU(d, &at[corner][2][i])};
    }
    void set(size_t corner, size_t i, const glm::vec3& p) {
        for (int axis = 0; axis < 3; ++axis) at[corner][axis][i] = p[axis];
    }
};

// Some faces about leaves that are near each other.
class Patch {
  public:
    static constexpr size_t kMost = 256;
    // Edges are near that are within 1.02 times the distance of the discs' points from their middle.  Those
    // that are not and yet cross a disc, seen from its normal, do so at least sqrt(2 * 0.02) radii up or
    // down: where faces are not as far up or down as this, such edges need not be looked for.
    static constexpr float kSteep = 0.19f;

    Patch(Surface& surface, uint32_t& now) : surface_(surface), now_(now) {}

    // Takes the faces about the leaves of some discs, no more than kMost, and those beyond their edges, until
    // no edge at the rim comes near a disc, or there are kMost.
    void take(std::span<const LeafDisc> discs) { take(discs, nullptr); }
    // The same for a single disc, up to where faces are not seen from its normal's side.
    void take_facing(const LeafDisc& disc) { take({&disc, 1}, &disc.frame.n); }

    // What is seen of it from one of its discs.
    struct View {
        bool is_whole = true;    // there are faces, and no edge at the rim crosses the disc
        bool is_folded = false;  // a face over the disc is not seen from the normal's side
        float height = 0;  // no face goes further up or down over the disc, if that is more than `enough`
        // Bound on the distance of the disc's points beyond the rim from it: on the way out from the disc's
        // centre, which is over a face, they have passed it.
        float overhang = 0;
    };
    View view(const LeafDisc& disc, float enough) const {
        Close close;
        close.count = 0;
        const glm::vec3 from(disc.centre - centre_);
        const D d;
        const V3 t1 = Set3(d, disc.frame.t1), t2 = Set3(d, disc.frame.t2), n = Set3(d, disc.frame.n);
        const V x0 = hn::Set(d, glm::dot(disc.frame.t1, from)),
                y0 = hn::Set(d, glm::dot(disc.frame.t2, from)), z0 = hn::Set(d, glm::dot(disc.frame.n, from));
        const V zero = hn::Zero(d), square = hn::Set(d, square_of(disc));
        for (size_t i = 0; i < count_; i += hn::Lanes(d)) {
            const V3 at[3] = {faces_.load(0, i), faces_.load(1, i), faces_.load(2, i)};
            const auto height = [&](size_t corner) HWY_ATTR { return hn::Sub(Dot(n, at[corner]), z0); };
            const V heights[3] = {height(0), height(1), height(2)};
            const V corners = hn::Max(hn::Abs(heights[0]), hn::Max(hn::Abs(heights[1]), hn::Abs(heights[2])));
            const auto facing = hn::Gt(Dot(n, normals_.load(0, i)), zero);
            auto matters = hn::Or(hn::Gt(corners, hn::Set(d, enough)), hn::Not(facing));
            if (has_rim_) matters = hn::Or(matters, hn::Ne(hn::LoadU(d, &rim_[i]), zero));
            matters = hn::And(matters, hn::FirstN(d, count_ - i));
            // Most often none does, and where the faces are over the disc is not asked.
            if (hn::AllFalse(d, matters)) continue;
            const auto turned = [&](size_t corner) HWY_ATTR {
                return V3{hn::Sub(Dot(t1, at[corner]), x0), hn::Sub(Dot(t2, at[corner]), y0),
                          heights[corner]};
            };
            const V3 a = turned(0), b = turned(1), c = turned(2);
            const V reach = reach_of(a, b, c, square);
            // The disc is beyond an edge.
            const auto is_beyond = [&](const V3& s, const V3& t) HWY_ATTR {
                const V dx = hn::Sub(t.x, s.x), dy = hn::Sub(t.y, s.y), area = Cross(s.x, s.y, t.x, t.y);
                return hn::And(
                    hn::Lt(area, zero),
                    hn::Gt(hn::Mul(area, area), hn::Mul(reach, hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)))));
            };
            matters = hn::AndNot(
                hn::And(facing, hn::Or(is_beyond(a, b), hn::Or(is_beyond(b, c), is_beyond(c, a)))), matters);
            if (hn::AllFalse(d, matters)) continue;
            const Pack<D> pack(matters);
            const V3* const points[3] = {&a, &b, &c};
            for (size_t k = 0; k < 3; ++k) {
                hn::StoreU(pack.of(points[k]->x), d, &close.faces.at[k][0][close.count]);
                hn::StoreU(pack.of(points[k]->y), d, &close.faces.at[k][1][close.count]);
                hn::StoreU(pack.of(points[k]->z), d, &close.faces.at[k][2][close.count]);
            }
            if (has_rim_) hn::StoreU(pack.of(hn::LoadU(d, &rim_[i])), d, &close.rim[close.count]);
            close.count += pack.count();
        }
        return view_of(close, disc);
    }

  private:
    static constexpr float kRoom = 1.02f;
    static constexpr size_t kPlaces = kMost + 4 * kSpare;

    // Those faces that matter to a disc, in its frame: it is about 0, across z.
    struct Close {
        size_t count;
        Corners<kPlaces> faces;
        alignas(64) float rim[kPlaces];  // as rim_
    };

    static float square_of(const LeafDisc& disc) { return disc.radius * disc.radius * 1.0001f; }
    // The disc is taken larger by what rounding may do.
    static V reach_of(const V3& a, const V3& b, const V3& c, V square) {
        const D d;
        const V most = hn::Max(SquareFromAxis(a), hn::Max(SquareFromAxis(b), SquareFromAxis(c)));
        return hn::Add(square, hn::Mul(most, hn::Set(d, 1e-6f)));
    }
    static V area_of(const V3& a, const V3& b, const V3& c) {
        return Cross(hn::Sub(b.x, a.x), hn::Sub(b.y, a.y), hn::Sub(c.x, a.x), hn::Sub(c.y, a.y));
    }

    View view_of(const Close& close, const LeafDisc& disc) const {
        const D d;
        const V zero = hn::Zero(d), square = hn::Set(d, square_of(disc));
        const auto is_left = [&](const V3& a, const V3& b)
                                 HWY_ATTR { return hn::Ge(Cross(a.x, a.y, b.x, b.y), zero); };
        V most = zero, beyond_most = zero;
        auto open = hn::FirstN(d, 0), folded = open;
        for (size_t i = 0; i < close.count; i += hn::Lanes(d)) {
            const auto valid = hn::FirstN(d, close.count - i);
            const V3 a = close.faces.load(0, i), b = close.faces.load(1, i), c = close.faces.load(2, i);
            const V reach = reach_of(a, b, c, square);
            const Crossing ab = CrossingOf(a, b, reach), bc = CrossingOf(b, c, reach),
                           ca = CrossingOf(c, a, reach);
            const auto about = hn::And(is_left(a, b), hn::And(is_left(b, c), is_left(c, a)));
            const auto meets =
                hn::And(valid, hn::Or(about, hn::Or(ab.is_over, hn::Or(bc.is_over, ca.is_over))));
            folded = hn::Or(folded, hn::AndNot(hn::Gt(area_of(a, b, c), zero), meets));
            // Highest and lowest a face is where its edges enter or leave the disc or end in it, or where the
            // disc's rim is furthest up or down its plane.
            const V edges = hn::Max(HeightOf(ab), hn::Max(HeightOf(bc), HeightOf(ca)));
            const V corners = hn::Max(hn::Abs(a.z), hn::Max(hn::Abs(b.z), hn::Abs(c.z)));
            most = hn::Max(most, hn::IfThenElseZero(
                                     meets, hn::Min(corners, hn::Max(edges, HeightAtRim(a, b, c, reach)))));
            if (!has_rim_) continue;
            const hn::RebindToSigned<D> di;
            const auto bits = hn::ConvertTo(di, hn::LoadU(d, &close.rim[i]));
            const auto beyond = [&](int k, const Crossing& crossing, const V3& s, const V3& t) HWY_ATTR {
                const auto is_rim = hn::And(hn::And(valid, crossing.is_over),
                                            hn::RebindMask(d, hn::TestBit(bits, hn::Set(di, 1 << k))));
                open = hn::Or(open, is_rim);
                const V out = hn::Max(zero, hn::Sub(hn::Set(d, disc.radius), hn::Sqrt(SquareFromAxis(s, t))));
                const V off = hn::Max(hn::Abs(s.z), hn::Abs(t.z));
                beyond_most = hn::Max(
                    beyond_most, hn::IfThenElseZero(is_rim, hn::Add(hn::Mul(out, out), hn::Mul(off, off))));
            };
            beyond(0, ab, a, b), beyond(1, bc, b, c), beyond(2, ca, c, a);
        }
        View view;
        view.is_whole = count_ > 0 && hn::AllFalse(d, open), view.is_folded = !hn::AllFalse(d, folded);
        view.height = hn::GetLane(hn::MaxOfLanes(d, most));
        if (!view.is_whole)
            view.overhang = is_over_centre(disc) ? std::sqrt(hn::GetLane(hn::MaxOfLanes(d, beyond_most)))
                                                 : std::numeric_limits<float>::infinity();
        return view;
    }

    // Is a face over the middle of the disc?
    HWY_NOINLINE bool is_over_centre(const LeafDisc& disc) const {
        const glm::vec3 from(disc.centre - centre_);
        for (size_t i = 0; i < count_; ++i) {
            glm::vec2 p[3];
            for (int k = 0; k < 3; ++k) {
                const glm::vec3 at =
                    glm::vec3(faces_.at[k][0][i], faces_.at[k][1][i], faces_.at[k][2][i]) - from;
                p[k] = {glm::dot(disc.frame.t1, at), glm::dot(disc.frame.t2, at)};
            }
            const auto is_left = [&](int k, int j) { return p[k].x * p[j].y - p[k].y * p[j].x >= 0; };
            if (is_left(0, 1) && is_left(1, 2) && is_left(2, 0)) return true;
        }
        return false;
    }

    void take(std::span<const LeafDisc> discs, const glm::vec3* normal) {
        glm::dvec3 low = discs[0].centre, high = low;
        for (const LeafDisc& disc : discs)
            low = glm::min(low, disc.centre), high = glm::max(high, disc.centre);
        centre_ = 0.5 * low + 0.5 * high;
        float reach = 0;
        for (const LeafDisc& disc : discs)
            reach = std::max(reach, float(glm::length(disc.centre - centre_)) + disc.radius);
        reach *= kRoom;
        now_ += 2;
        count_ = 0, has_rim_ = normal != nullptr;
        for (const LeafDisc& disc : discs)
            for (uint32_t k = surface_.fan_begin[disc.leaf]; k < surface_.fan_begin[disc.leaf + 1]; ++k)
                append(Surface::face_of(surface_.fan_side[k]));
        for (size_t done = 0, end; done < count_; done = end) {
            end = std::min(count_, done + kSpare);
            if (normal && has_averted(done, end, *normal)) count_ = end = done;
            for (size_t i = done; i < end; ++i) place(i);
            set_normals(done);
            if (count_ > kMost)
                has_rim_ = true;
            else
                grow(done, end - done, reach * reach);
        }
        if (has_rim_) find_rim();
    }

    // Marks are now - 1 of faces that were looked at, and in find_rim() now of those that were taken.
    void append(uint32_t face) {
        face_[count_] = face;
        uint32_t& mark = surface_.faces[face].mark;
        count_ += mark < now_ - 1;
        mark = now_ - 1;
    }

    glm::vec3 corner(uint32_t face, int k) const {
        return glm::vec3(surface_.at[surface_.faces[face].corner[k]] - centre_);
    }
    void place(size_t i) {
        const Surface::Face& face = surface_.faces[face_[i]];
        for (int k = 0; k < 3; ++k) {
            // grow() will ask for its mark.
            if (face.against[k] != Surface::kNone)
                hwy::Prefetch(&surface_.faces[Surface::face_of(face.against[k])]);
            faces_.set(size_t(k), i, corner(face_[i], k));
        }
    }

    void set_normals(size_t first) {
        const D d;
        for (size_t i = first; i < first + kSpare; i += hn::Lanes(d)) {
            const V3 a = faces_.load(0, i), b = faces_.load(1, i), c = faces_.load(2, i);
            const V3 p{hn::Sub(b.x, a.x), hn::Sub(b.y, a.y), hn::Sub(b.z, a.z)},
                q{hn::Sub(c.x, a.x), hn::Sub(c.y, a.y), hn::Sub(c.z, a.z)};
            normals_.store(0, i,
                           {Cross(p.y, p.z, q.y, q.z), Cross(p.z, p.x, q.z, q.x), Cross(p.x, p.y, q.x, q.y)});
        }
    }

    HWY_NOINLINE bool has_averted(size_t begin, size_t end, const glm::vec3& normal) const {
        return std::any_of(face_ + begin, face_ + end, [&](uint32_t face) {
            const glm::vec3 p = corner(face, 0);
            return !(glm::dot(normal, glm::cross(corner(face, 1) - p, corner(face, 2) - p)) > 0);
        });
    }

    // Appends the faces beyond those edges of some faces that come near the discs.
    void grow(size_t first, size_t count, float square) {
        const D d;
        const V most = hn::Set(d, square);
        const auto near = [&](const V3& s, const V3& t, V ss, V tt) HWY_ATTR {
            const V3 to{hn::Sub(t.x, s.x), hn::Sub(t.y, s.y), hn::Sub(t.z, s.z)};
            const V all = Dot(to, to), along = hn::Neg(Dot(s, to));
            const auto foot_is_near =
                hn::And(hn::And(hn::Gt(along, hn::Zero(d)), hn::Lt(along, all)),
                        hn::Le(hn::Sub(hn::Mul(ss, all), hn::Mul(along, along)), hn::Mul(most, all)));
            return uint64_t(BitsOf(d, hn::Or(foot_is_near, hn::Le(hn::Min(ss, tt), most))));
        };
        static_assert(kSpare == 16);
        uint64_t edges = 0;
        for (size_t i = 0; i < kSpare; i += hn::Lanes(d)) {
            const V3 a = faces_.load(0, first + i), b = faces_.load(1, first + i),
                     c = faces_.load(2, first + i);
            const V aa = Dot(a, a), bb = Dot(b, b), cc = Dot(c, c);
            edges |= (near(a, b, aa, bb) | near(b, c, bb, cc) << 16 | near(c, a, cc, aa) << 32) << i;
        }
        edges &= ((uint64_t(1) << count) - 1) * 0x100010001u;
        for (; edges; edges &= edges - 1) {
            const auto at = unsigned(__builtin_ctzll(edges));
            const uint32_t against = surface_.faces[face_[first + at % 16]].against[at / 16];
            if (against == Surface::kNone)
                has_rim_ = true;
            else
                append(Surface::face_of(against));
        }
    }

    HWY_NOINLINE void find_rim() {
        for (size_t i = 0; i < count_; ++i) surface_.faces[face_[i]].mark = now_;
        for (size_t i = 0; i < count_; ++i) {
            int edges = 0;
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t against = surface_.faces[face_[i]].against[k];
                if (against == Surface::kNone || surface_.faces[Surface::face_of(against)].mark != now_)
                    edges |= 1 << k;
            }
            rim_[i] = float(edges);
        }
    }

    Surface& surface_;
    uint32_t& now_;
    glm::dvec3 centre_{0};
    size_t count_ = 0;
    bool has_rim_ = false;            // near a disc
    Corners<kPlaces> faces_;          // relative to the centre
    Corners<kPlaces, 1> normals_;     // their normals, of any length
    alignas(64) float rim_[kPlaces];  // a bit for each edge that has no face of the patch on its other side
    uint32_t face_[kPlaces];
};

// A triangle, with what its distance from points is found by.
class MeasuredTriangle {
  public:
    MeasuredTriangle() = default;
    MeasuredTriangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
        : normal_(glm::cross(b - a, c - a)) {
        const float area = glm::dot(normal_, normal_);
        has_area_ = area > 0, inverse_area_ = 1.0f / area;
        const glm::vec3* const corners[4] = {&a, &b, &c, &a};
        for (int k = 0; k < 3; ++k) {
            Edge& edge = edge_[k];
            edge.from = *corners[k], edge.along = *corners[k + 1] - *corners[k];
            const float square = glm::dot(edge.along, edge.along);
            edge.inverse = square > 0 ? 1.0f / square : 0.0f;
            edge.inwards = glm::cross(normal_, edge.along);
        }
    }

    // Square of the distance from (px, py, 0): to its plane where the foot is inside, else to the edges.
    template <class D, class V = hn::Vec<D>>
    HWY_INLINE V square_from(D d, V px, V py) const {
        const V edges = hn::Min(square_to(d, edge_[0], px, py),
                                hn::Min(square_to(d, edge_[1], px, py), square_to(d, edge_[2], px, py)));
        if (!has_area_) return edges;
        const auto inside = hn::And(is_inside(d, edge_[0], px, py),
                                    hn::And(is_inside(d, edge_[1], px, py), is_inside(d, edge_[2], px, py)));
        const glm::vec3& a = edge_[0].from;
        const V x = hn::Sub(px, hn::Set(d, a.x)), y = hn::Sub(py, hn::Set(d, a.y));
        const V plane = hn::Add(hn::Add(hn::Mul(x, hn::Set(d, normal_.x)), hn::Mul(y, hn::Set(d, normal_.y))),
                                hn::Set(d, -a.z * normal_.z));
        return hn::IfThenElse(inside, hn::Mul(hn::Mul(plane, plane), hn::Set(d, inverse_area_)), edges);
    }

  private:
    struct Edge {
        glm::vec3 from, along, inwards;  // inwards: across the edge, in the plane
        float inverse;                   // of its length's square; 0 of none
    };

    template <class D, class V = hn::Vec<D>>
    static HWY_INLINE V square_to(D d, const Edge& edge, V px, V py) {
        const glm::vec3 &from = edge.from, &e = edge.along;
        const V x = hn::Sub(px, hn::Set(d, from.x)), y = hn::Sub(py, hn::Set(d, from.y)),
                z = hn::Set(d, -from.z);
        const V dot = hn::Add(hn::Add(hn::Mul(x, hn::Set(d, e.x)), hn::Mul(y, hn::Set(d, e.y))),
                              hn::Mul(z, hn::Set(d, e.z)));
        const V t = hn::Min(hn::Set(d, 1.0f), hn::Max(hn::Zero(d), hn::Mul(dot, hn::Set(d, edge.inverse))));
        const V u = hn::Sub(x, hn::Mul(t, hn::Set(d, e.x))), v = hn::Sub(y, hn::Mul(t, hn::Set(d, e.y))),
                w = hn::Sub(z, hn::Mul(t, hn::Set(d, e.z)));
        return hn::Add(hn::Add(hn::Mul(u, u), hn::Mul(v, v)), hn::Mul(w, w));
    }
    template <class D, class V = hn::Vec<D>>
    static HWY_INLINE hn::Mask<D> is_inside(D d, const Edge& edge, V px, V py) {
        const glm::vec3 &from = edge.from, &m = edge.inwards;
        const V x = hn::Sub(px, hn::Set(d, from.x)), y = hn::Sub(py, hn::Set(d, from.y));
        return hn::Ge(hn::Add(hn::Add(hn::Mul(x, hn::Set(d, m.x)), hn::Mul(y, hn::Set(d, m.y))),
                              hn::Set(d, -from.z * m.z)),
                      hn::Zero(d));
    }

    Edge edge_[3];
    glm::vec3 normal_;
    float inverse_area_;
    bool has_area_;
};

// Of order 1: squares stay in range.
glm::vec3 InUnitsOf(const LeafDisc& disc, const glm::dvec3& at) {
    const glm::vec3 x(at - disc.centre);
    return glm::vec3(glm::dot(disc.frame.t1, x), glm::dot(disc.frame.t2, x), glm::dot(disc.frame.n, x)) /
           disc.radius;
}

// Bound on the distance of the disc's points from the faces about some corners (of more than kMost, the first
// ones).
constexpr size_t kMostNearFaces = 256;
HWY_NOINLINE float FacesError(const Surface& surface, const LeafDisc& disc,
                              std::span<const uint32_t> corners) {
    const auto is_before = [&](uint32_t corner, size_t n) {
        return std::find(corners.begin(), corners.begin() + ptrdiff_t(n), corner) !=
               corners.begin() + ptrdiff_t(n);
    };
    MeasuredTriangle face[kMostNearFaces];
    size_t taken = 0;
    for (size_t n = 0; n < corners.size(); ++n)
        for (uint32_t k = surface.fan_begin[corners[n]];
             k < surface.fan_begin[corners[n] + 1] && taken < kMostNearFaces; ++k) {
            const glm::u32vec2 others = surface.fan[k];
            if (is_before(others.x, n) || is_before(others.y, n)) continue;
            face[taken++] = {InUnitsOf(disc, surface.at[corners[n]]), InUnitsOf(disc, surface.at[others.x]),
                             InUnitsOf(disc, surface.at[others.y])};
        }
    const auto square_of = [&](size_t k, auto x, auto y) { return face[k].square_from(Sectors(), x, y); };
    const auto error = [](size_t) { return 0.0f; };
    return disc.radius * Cells(1.0f, taken, square_of, error).fine_bound(kErrorOfRadius[disc.flatness][0]);
}

// From those about the leaf and about its neighbours that are not far from the disc.
float NearFacesError(const Surface& surface, const LeafDisc& disc) {
    const uint32_t leaf = disc.leaf;
    uint32_t pivots[kMostNearFaces] = {leaf};
    size_t count = 1;
    for (uint32_t k = surface.fan_begin[leaf]; k < surface.fan_begin[leaf + 1]; ++k)
        for (const uint32_t corner : {surface.fan[k].x, surface.fan[k].y})
            if (count < kMostNearFaces && std::find(pivots, pivots + count, corner) == pivots + count &&
                glm::length(InUnitsOf(disc, surface.at[corner])) < 2)
                pivots[count++] = corner;
    return FacesError(surface, disc, {pivots, count});
}

// By a patch of its own.
HWY_NOINLINE float LoneError(const Surface& surface, const LeafDisc& disc, Patch& patch) {
    if (!surface.is_closed[disc.leaf] || surface.valence(disc.leaf) > Patch::kMost)
        return NearFacesError(surface, disc);
    patch.take_facing(disc);
    const Patch::View view = patch.view(disc, 0);
    if (view.is_folded) return NearFacesError(surface, disc);
    if (view.is_whole) return view.height;
    const float bound = std::max(view.height, view.overhang);
    return encode_error(bound, disc.radius, disc.flatness) == 0
               ? bound
               : std::min(bound, NearFacesError(surface, disc));
}

// The patch about some leaves is grown until its rim is outside their discs.  If all its faces over a disc
// are seen from the normal's side, their projection covers the whole disc (its degree over the disc is
// constant, and positive at the vertex), so that over each point of the disc there is surface, no further up
// or down than the faces that meet the disc go.  Where they fold over or end, each leaf has its own patch of
// faces that do not fold over; where it ends over the disc, it is the distance from its rim, or to the faces
// near the leaf.
//
// Leaves share a patch: with one for each, grown only where edges cross its disc, there are 13 faces to look
// at, and all takes a fifth longer.
void LeafErrors(Surface& surface, std::span<const LeafDisc> discs, uint32_t& now, float* errors) {
    Patch patch(surface, now);
    size_t faces = 0;
    bool is_closed = true;
    for (const LeafDisc& disc : discs)
        faces += surface.valence(disc.leaf), is_closed &= surface.is_closed[disc.leaf] != 0;
    std::vector<const LeafDisc*> lone;
    if (is_closed && faces <= Patch::kMost) {
        patch.take(discs);
        for (size_t k = 0; k < discs.size(); ++k) {
            // A little less than the first code, for what is added for rounding.
            const float enough =
                discs[k].radius * std::min(0.999f * kErrorOfRadius[discs[k].flatness][0], Patch::kSteep);
            const Patch::View view = patch.view(discs[k], enough);
            if (view.is_whole && !view.is_folded && view.height < Patch::kSteep * discs[k].radius)
                errors[k] = std::max(view.height, enough);
            else
                lone.push_back(&discs[k]);
        }
    } else {
        for (const LeafDisc& disc : discs) lone.push_back(&disc);
    }
    for (const LeafDisc* disc : lone) errors[disc - discs.data()] = LoneError(surface, *disc, patch);
}

// The same for a leaf that is a triangle, in units of the disc's radius.
class Ring {
  public:
    Ring(const Surface& surface, const LeafDisc& disc)
        : fans_(surface.triangles), own_(fans_.corners[disc.leaf]), inverse_(1.0f / disc.radius) {
        frame_ = {inverse_ * disc.frame.t1, inverse_ * disc.frame.t2, inverse_ * disc.frame.n};
        for (int k = 0; k < 3; ++k) corner_[k] = turned(fans_.at[own_[k]] - disc.centre);
    }

    // Looks at all faces about the triangle's corners.  False where some are not known, or one is not seen
    // from the normal's side.
    bool look() {
        for (int k = 0; k < 3; ++k) {
            if (!fans_.is_closed[own_[k]]) return false;
            for (uint32_t at = fans_.begin[own_[k]]; at < fans_.begin[own_[k] + 1];
                 at += uint32_t(hn::Lanes(D())))
                if (!look_at(corner_[k], at, fans_.begin[own_[k] + 1] - at)) return false;
        }
        return true;
    }

    // As of Patch, over the disc.
    float height() const { return height_; }
    float overhang() const { return is_over_centre_ ? overhang_ : std::numeric_limits<float>::infinity(); }

    // Bound on the distance of the disc's points from these faces (of more than kMost, the first ones).
    HWY_NOINLINE float distance(float enough) const {
        constexpr size_t kMost = 64;
        MeasuredTriangle face[kMost];
        face[0] = {corner_[0], corner_[1], corner_[2]};
        size_t count = 1;
        for (int k = 0; k < 3; ++k)
            for (uint32_t at = fans_.begin[own_[k]]; at < fans_.begin[own_[k] + 1] && count < kMost; ++at) {
                const glm::u32vec2 others = fans_.fan[at];
                bool is_known = is_own(others.x) && is_own(others.y);
                for (int before = 0; before < k; ++before)
                    is_known |= others.x == own_[before] || others.y == own_[before];
                if (is_known) continue;
                face[count++] = {corner_[k], corner_[k] + turned(fans_.p.get(at)),
                                 corner_[k] + turned(fans_.q.get(at))};
            }
        const auto square_of = [&](size_t k, auto x, auto y) { return face[k].square_from(Sectors(), x, y); };
        const auto error = [](size_t) { return 0.0f; };
        return Cells(1.0f, count, square_of, error).fine_bound(enough);
    }

  private:
    static constexpr float kSquare = 1.0001f;  // of the disc's radius

    glm::vec3 turned(const glm::dvec3& p) const { return turned(glm::vec3(p)); }
    glm::vec3 turned(const glm::vec3& p) const {
        return {glm::dot(frame_.t1, p), glm::dot(frame_.t2, p), glm::dot(frame_.n, p)};
    }
    bool is_own(uint32_t vertex) const { return vertex == own_.x || vertex == own_.y || vertex == own_.z; }

    bool look_at(const glm::vec3& vertex, uint32_t at, uint32_t count) {
        const D d;
        const hn::RebindToUnsigned<D> du;
        const auto valid = hn::FirstN(d, count);
        const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), square = hn::Set(d, kSquare);
        const V3 v = Set3(d, vertex), p = Plus(v, Turn(fans_.p, at)), q = Plus(v, Turn(fans_.q, at));
        const V area = Cross(hn::Sub(p.x, v.x), hn::Sub(p.y, v.y), hn::Sub(q.x, v.x), hn::Sub(q.y, v.y));
        if (!hn::AllTrue(d, hn::Or(hn::Not(valid), hn::Gt(area, zero)))) return false;
        const V edges = hn::Max(HeightOf(CrossingOf(p, q, square)), HeightOf(CrossingOf(v, p, square)));
        const V corners = hn::Max(hn::Abs(v.z), hn::Max(hn::Abs(p.z), hn::Abs(q.z)));
        const V height = hn::Min(corners, hn::Max(edges, HeightAtRim(v, p, q, square)));
        height_ = std::max(height_, hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(valid, height))));
        const auto is_left = [&](const V3& a, const V3& b)
                                 HWY_ATTR { return hn::Ge(Cross(a.x, a.y, b.x, b.y), zero); };
        is_over_centre_ |=
            !hn::AllFalse(d, hn::And(valid, hn::And(is_left(v, p), hn::And(is_left(p, q), is_left(q, v)))));
        // The edges opposite to the corner that have none of the others either are the ring's rim.
        hn::Vec<decltype(du)> from, to;
        hn::LoadInterleaved2(du, &fans_.fan[at].x, from, to);
        auto is_rim = hn::RebindMask(du, valid);
        for (int k = 0; k < 3; ++k) {
            const auto corner = hn::Set(du, own_[k]);
            is_rim = hn::And(is_rim, hn::And(hn::Ne(from, corner), hn::Ne(to, corner)));
        }
        const V from_axis = SquareFromAxis(p, q);
        const V beyond = hn::Max(zero, hn::Sub(one, hn::Sqrt(from_axis))),
                off = hn::Max(hn::Abs(p.z), hn::Abs(q.z));
        const V over = hn::IfThenElseZero(hn::And(hn::RebindMask(d, is_rim), hn::Le(from_axis, square)),
                                          hn::Sqrt(hn::Add(hn::Mul(beyond, beyond), hn::Mul(off, off))));
        overhang_ = std::max(overhang_, hn::GetLane(hn::MaxOfLanes(d, over)));
        return true;
    }

    V3 Turn(const PointArrays& points, uint32_t at) const {
        const D d;
        const V3 p{hn::LoadU(d, &points.x[at]), hn::LoadU(d, &points.y[at]), hn::LoadU(d, &points.z[at])};
        return {Dot(Set3(d, frame_.t1), p), Dot(Set3(d, frame_.t2), p), Dot(Set3(d, frame_.n), p)};
    }
    static V3 Plus(const V3& a, const V3& b) {
        return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
    }

    const TriangleFans& fans_;
    const glm::u32vec3 own_;
    const float inverse_;
    Frame frame_;
    glm::vec3 corner_[3];
    float height_ = 0, overhang_ = 0;
    bool is_over_centre_ = false;
};

// The disc holds the triangle's corners in its projection.  Where the faces about them go round each, all are
// seen from the normal's side, and the edges about all of them do not cross the disc, there is surface over
// each point of the disc, as of a vertex's leaf; where such an edge crosses it, the disc's rest is beyond.
float TriangleError(const Surface& surface, const LeafDisc& disc) {
    Ring ring(surface, disc);
    if (!ring.look()) return disc.radius * ring.distance(kErrorOfRadius[disc.flatness][0]);
    return disc.radius * std::max(ring.height(), ring.overhang());
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(LeafErrors);
HWY_EXPORT(FacesError);
HWY_EXPORT(TriangleError);

void leaf_errors(Surface& surface, std::span<const LeafDisc> discs, uint32_t& now, std::span<float> errors) {
    HWY_DYNAMIC_DISPATCH(LeafErrors)(surface, discs, now, errors.data());
}

float faces_error(const Surface& surface, const LeafDisc& disc, std::span<const uint32_t> leaves) {
    return HWY_DYNAMIC_DISPATCH(FacesError)(surface, disc, leaves);
}

float triangle_error(const Surface& surface, const LeafDisc& disc) {
    return HWY_DYNAMIC_DISPATCH(TriangleError)(surface, disc);
}

}  // namespace splat
#endif
