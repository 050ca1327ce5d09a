#include "splat/build/surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/node.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/build/surface.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "core/pack-inl.h"

#ifndef QS_SPLAT_SURFACE_ONCE
#define QS_SPLAT_SURFACE_ONCE
namespace splat {
namespace {

// Faces (0, p, q) about some leaves, lengths from 1e-75 to 1e75, and what is found of each.
struct Faces {
    std::vector<double> p[3], q[3], cross[3];  // cross: p x q
    std::vector<float> normal[3];              // unit; 0 for a face without area
    std::vector<float> to_p[3], to_q[3];       // half the way
    // Corners of the share beside 0 and p / 2 (and q / 2, which is another face's p / 2 where the fan is
    // closed).
    std::vector<float> first[3], second[3];
    std::vector<float> corners;  // how many of the two there are

    void resize(size_t n) {
        for (auto* channels : {p, q, cross})
            for (int k = 0; k < 3; ++k) channels[k].resize(n);
        for (auto* channels : {normal, to_p, to_q, first, second})
            for (int k = 0; k < 3; ++k) channels[k].resize(n);
        corners.resize(n);
    }
};

// A leaf's among them: `count` from `first` on; `siblings` leaves from `sibling` on are its group.
struct LeafFaces {
    const glm::u32vec2* fan;
    size_t first;
    uint32_t count, sibling, siblings;
    bool is_closed;
};

constexpr uint32_t kLone = ~0u;

}  // namespace
}  // namespace splat
#endif  // QS_SPLAT_SURFACE_ONCE

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using core::HWY_NAMESPACE::Pack;

// In double: a needle's circumcentre needs it.
void ShareOut(Faces& faces, size_t count) {
    const hn::CappedTag<double, kSpare> d;
    const hn::Rebind<float, decltype(d)> df;
    using V = hn::Vec<decltype(d)>;
    struct V3 {
        V x, y, z;
    };
    const auto load = [&](const std::vector<double>* a, size_t i) {
        return V3{hn::LoadU(d, &a[0][i]), hn::LoadU(d, &a[1][i]), hn::LoadU(d, &a[2][i])};
    };
    const auto store = [&](const V3& v, std::vector<float>* a, size_t i) {
        hn::StoreU(hn::DemoteTo(df, v.x), df, &a[0][i]), hn::StoreU(hn::DemoteTo(df, v.y), df, &a[1][i]);
        hn::StoreU(hn::DemoteTo(df, v.z), df, &a[2][i]);
    };
    const auto dot = [](const V3& a, const V3& b) {
        return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
    };
    const auto sum = [](V s, const V3& a, V t, const V3& b) {
        return V3{hn::Add(hn::Mul(s, a.x), hn::Mul(t, b.x)), hn::Add(hn::Mul(s, a.y), hn::Mul(t, b.y)),
                  hn::Add(hn::Mul(s, a.z), hn::Mul(t, b.z))};
    };
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        const V3 p = load(faces.p, i), q = load(faces.q, i);
        const V pp = dot(p, p), qq = dot(q, q), pq = dot(p, q);
        const V at_p = hn::Sub(pp, pq),
                at_q = hn::Sub(qq, pq);  // cosines of the angles at p and q, times lengths
        const V area2 = hn::Sub(hn::Mul(pp, qq), hn::Mul(pq, pq));
        // Needle and zero-area faces give the whole face.
        const auto is_face = hn::Gt(area2, hn::Mul(hn::Set(d, 1e-18), hn::Mul(pp, qq)));
        const auto obtuse = hn::And(is_face, hn::Le(pq, zero));  // here: two points on the far edge
        const auto sharp = hn::AndNot(obtuse, is_face);
        const auto obtuse_p = hn::And(sharp, hn::Le(at_p, zero)),
                   obtuse_q = hn::And(sharp, hn::Le(at_q, zero));
        // The circumcentre, then the other cases, as weights of p and q.
        V s = hn::Div(hn::Mul(qq, at_p), hn::Add(area2, area2)),
          t = hn::Div(hn::Mul(pp, at_q), hn::Add(area2, area2));
        const V beyond_p = hn::Div(hn::Mul(half, pp), at_p), beyond_q = hn::Div(hn::Mul(half, qq), at_q);
        s = hn::IfThenElse(obtuse, hn::Sub(one, beyond_p), s), t = hn::IfThenElse(obtuse, beyond_p, t);
        s = hn::IfThenZeroElse(obtuse_p, s), t = hn::IfThenElse(obtuse_p, hn::Div(hn::Mul(half, pp), pq), t);
        s = hn::IfThenElse(is_face, s, one), t = hn::IfThenElseZero(is_face, t);
        store(V3{hn::Mul(half, p.x), hn::Mul(half, p.y), hn::Mul(half, p.z)}, faces.to_p, i);
        store(V3{hn::Mul(half, q.x), hn::Mul(half, q.y), hn::Mul(half, q.z)}, faces.to_q, i);
        store(sum(s, p, t, q), faces.first, i);
        store(sum(hn::IfThenElseZero(obtuse, beyond_q), p,
                  hn::IfThenElse(obtuse, hn::Sub(one, beyond_q), one), q),
              faces.second, i);
        const V corners =
            hn::IfThenZeroElse(obtuse_q, hn::IfThenElse(hn::AndNot(obtuse, is_face), one, hn::Add(one, one)));
        hn::StoreU(hn::DemoteTo(df, corners), df, &faces.corners[i]);
        const V3 cross{hn::Sub(hn::Mul(p.y, q.z), hn::Mul(p.z, q.y)),
                       hn::Sub(hn::Mul(p.z, q.x), hn::Mul(p.x, q.z)),
                       hn::Sub(hn::Mul(p.x, q.y), hn::Mul(p.y, q.x))};
        hn::StoreU(cross.x, d, &faces.cross[0][i]), hn::StoreU(cross.y, d, &faces.cross[1][i]),
            hn::StoreU(cross.z, d, &faces.cross[2][i]);
        const V length = hn::Sqrt(dot(cross, cross));
        const auto has_area = hn::Gt(length, hn::Add(hn::Mul(hn::Set(d, 1e-12), pp), hn::Set(d, 1e-290)));
        const V inverse = hn::IfThenElseZero(has_area, hn::Div(one, length));
        store(V3{hn::Mul(cross.x, inverse), hn::Mul(cross.y, inverse), hn::Mul(cross.z, inverse)},
              faces.normal, i);
    }
}

// Behind corners.x[corner] come the leaf's share corners, those that its siblings' hull holds last, behind
// normals.x[normal] its faces' unit normals; these are moved on.
void AddFaces(const Faces& faces, const LeafFaces& leaf, Surface& out, uint32_t& corner, uint32_t& rim_end,
              uint32_t& normal) {
    const hn::CappedTag<float, kSpare> d;
    const hn::Rebind<uint32_t, decltype(d)> du;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const auto sibling = hn::Set(du, leaf.sibling), siblings = hn::Set(du, leaf.siblings);
    using M = hn::Mask<decltype(d)>;
    const auto put = [&](const std::vector<float>* from, size_t at, M mask, PointArrays& to, uint32_t& end)
                         HWY_ATTR {
                             const Pack<decltype(d)> pack(mask);
                             hn::StoreU(pack.of(hn::LoadU(d, &from[0][at])), d, &to.x[end]);
                             hn::StoreU(pack.of(hn::LoadU(d, &from[1][at])), d, &to.y[end]);
                             hn::StoreU(pack.of(hn::LoadU(d, &from[2][at])), d, &to.z[end]);
                             end += uint32_t(pack.count());
                         };
    for (const bool is_inside : {false, true}) {
        for (uint32_t k = 0; k < leaf.count; k += uint32_t(hn::Lanes(d))) {
            const size_t at = leaf.first + k;
            hn::Vec<decltype(du)> p, q;
            hn::LoadInterleaved2(du, &leaf.fan[k].x, p, q);
            const auto valid = hn::FirstN(d, leaf.count - k);
            const M to_p = hn::RebindMask(d, hn::Lt(hn::Sub(p, sibling), siblings)),
                    to_q = hn::RebindMask(d, hn::Lt(hn::Sub(q, sibling), siblings));
            const auto wanted = [&](M inside) HWY_ATTR {
                return is_inside ? hn::And(inside, valid) : hn::AndNot(inside, valid);
            };
            put(faces.to_p, at, wanted(to_p), out.corners, corner);
            if (!leaf.is_closed) put(faces.to_q, at, wanted(to_q), out.corners, corner);
            const M among = wanted(hn::And(to_p, to_q));
            const auto corners = hn::LoadU(d, &faces.corners[at]);
            put(faces.first, at, hn::And(among, hn::Gt(corners, zero)), out.corners, corner);
            put(faces.second, at, hn::And(among, hn::Gt(corners, one)), out.corners, corner);
        }
        if (!is_inside) rim_end = corner;
    }
    for (uint32_t k = 0; k < leaf.count; k += uint32_t(hn::Lanes(d))) {
        const size_t at = leaf.first + k;
        const M has_area = hn::Or(hn::Ne(hn::LoadU(d, &faces.normal[0][at]), zero),
                                  hn::Or(hn::Ne(hn::LoadU(d, &faces.normal[1][at]), zero),
                                         hn::Ne(hn::LoadU(d, &faces.normal[2][at]), zero)));
        put(faces.normal, at, hn::And(has_area, hn::FirstN(d, leaf.count - k)), out.face_normals, normal);
    }
}

// For each p of a fan where the same corner is a q: kLone where there is not exactly one of each.  True where
// there are as many of each.
bool MatchFan(const glm::u32vec2* fan, uint32_t count, uint32_t* match) {
    const hn::CappedTag<uint32_t, kSpare> d;
    const auto lanes = uint32_t(hn::Lanes(d));
    bool is_closed = count > 0;
    for (uint32_t k = 0; k < count; ++k) {
        const auto wanted = hn::Set(d, fan[k].x);
        size_t out = 0, in = 0;
        match[k] = kLone;
        for (uint32_t at = 0; at < count; at += lanes) {
            hn::Vec<decltype(d)> p, q;
            hn::LoadInterleaved2(d, &fan[at].x, p, q);
            const auto valid = hn::FirstN(d, count - at);
            const auto same = hn::And(valid, hn::Eq(q, wanted));
            out += hn::CountTrue(d, hn::And(valid, hn::Eq(p, wanted))), in += hn::CountTrue(d, same);
            if (const intptr_t found = hn::FindFirstTrue(d, same); found >= 0)
                match[k] = at + uint32_t(found);
        }
        is_closed &= out == in;
        if (out != 1 || in != 1) match[k] = kLone;
    }
    return is_closed;
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(ShareOut);
HWY_EXPORT(AddFaces);
HWY_EXPORT(MatchFan);

namespace {

class Gatherer {
  public:
    explicit Gatherer(const SubtreeInput& input) : in_(input), base_(input.model(input.begin)) {
        out_.count = input.end - input.begin, out_.base = base_;
    }

    Surface run() {
        number_corners();
        gather_fans();
        reserve();
        for (uint32_t begin = 0; begin < out_.count;) begin = gather_leaves(begin);
        out_.corners.resize(out_.corner_begin.back() + kSpare);
        out_.face_normals.resize(out_.normal_begin.back() + kSpare);
        return std::move(out_);
    }

  private:
    void number_corners() {
        out_.at.reserve(out_.count + out_.count / 4), out_.leaf.reserve(out_.count + out_.count / 4);
        for (uint32_t i = 0; i < out_.count; ++i)
            out_.at.push_back(in_.model(in_.begin + i) - base_), out_.leaf.push_back(in_.begin + i);
        std::vector<glm::u32vec3> faces(in_.faces.size());
        for (size_t f = 0; f < faces.size(); ++f)
            for (int k = 0; k < 3; ++k) faces[f][k] = number_of(in_.faces[f][k]);
        sort_faces(faces);
    }

    // In the order of their lowest corners, so that what is near in the tree is near in memory: in that of
    // the input all that follows takes a tenth longer.
    void sort_faces(const std::vector<glm::u32vec3>& faces) {
        const auto lowest = [](const glm::u32vec3& c) { return std::min(c.x, std::min(c.y, c.z)); };
        std::vector<uint32_t> to(out_.at.size() + 1, 0);
        for (const glm::u32vec3& c : faces) ++to[lowest(c) + 1];
        std::partial_sum(to.begin(), to.end(), to.begin());
        out_.faces.resize(faces.size());
        for (const glm::u32vec3& c : faces) out_.faces[to[lowest(c)]++].corner = c;
    }

    // Open addressing: strangers are few, and looked up often.
    uint32_t number_of(uint32_t leaf) {
        if (leaf - in_.begin < out_.count) return leaf - in_.begin;  // wraps where it is below begin
        if (2 * (out_.at.size() - out_.count) >= strangers_.size())
            rehash(std::max<size_t>(256, 2 * strangers_.size()));
        size_t slot = mix(leaf) >> 32 & (strangers_.size() - 1);
        while (strangers_[slot] != 0 && out_.leaf[strangers_[slot]] != leaf)
            slot = (slot + 1) & (strangers_.size() - 1);
        if (strangers_[slot] == 0) {
            strangers_[slot] = uint32_t(out_.at.size());  // never 0: number 0 is a leaf of ours
            out_.at.push_back(in_.model(leaf) - base_), out_.leaf.push_back(leaf);
        }
        return strangers_[slot];
    }
    void rehash(size_t size) {
        strangers_.assign(size, 0);
        for (size_t n = out_.count; n < out_.at.size(); ++n) {
            size_t slot = mix(out_.leaf[n]) >> 32 & (size - 1);
            while (strangers_[slot] != 0) slot = (slot + 1) & (size - 1);
            strangers_[slot] = uint32_t(n);
        }
    }
    static uint64_t mix(uint64_t x) {
        x = (x + 1) * 0x9e3779b97f4a7c15u;
        return x ^ x >> 29;
    }

    void gather_fans() {
        out_.fan_begin.assign(out_.at.size() + 1, 0);
        for (const Surface::Face& face : out_.faces)
            for (int k = 0; k < 3; ++k) ++out_.fan_begin[face.corner[k] + 1];
        for (size_t i = 0; i < out_.at.size(); ++i) out_.fan_begin[i + 1] += out_.fan_begin[i];
        out_.fan.resize(out_.fan_begin.back() + kSpare), out_.fan_side.resize(out_.fan_begin.back());
        std::vector<uint32_t> to(out_.fan_begin.begin(), out_.fan_begin.end() - 1);
        for (uint32_t f = 0; f < out_.faces.size(); ++f) {
            const glm::u32vec3& c = out_.faces[f].corner;
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t entry = to[c[k]]++;
                out_.fan[entry] = {c[(k + 1) % 3], c[(k + 2) % 3]};
                out_.fan_side[entry] = Surface::side_of(f, k);
            }
        }
        match_sides();
    }

    // Within the faces about a corner, the edge that goes out to another corner meets the one that comes in
    // from there.
    void match_sides() {
        out_.is_closed.resize(out_.count);
        std::vector<uint32_t> match;
        for (uint32_t i = 0; i < out_.at.size(); ++i) {
            const uint32_t begin = out_.fan_begin[i], count = out_.valence(i);
            if (match.size() < count) match.resize(2 * size_t(count));
            const bool is_closed = HWY_DYNAMIC_DISPATCH(MatchFan)(&out_.fan[begin], count, match.data());
            if (i < out_.count) out_.is_closed[i] = is_closed;
            for (uint32_t k = 0; k < count; ++k)
                if (match[k] != kLone)
                    set_against(out_.fan_side[begin + k], incoming(out_.fan_side[begin + match[k]]));
        }
    }
    void set_against(uint32_t side, uint32_t other) {
        out_.faces[Surface::face_of(side)].against[side % 4] = other;
    }
    // Of a face, the edge before one.
    static uint32_t incoming(uint32_t side) { return side % 4 == 0 ? side + 2 : side - 1; }

    void reserve() {
        const size_t faces = out_.fan_begin[out_.count];
        out_.corners.resize(in_.cloud_radii.empty() ? out_.count + 2 * faces : out_.count * (kDisc + 1));
        out_.face_normals.resize(faces + 2 * size_t(out_.count) + kSpare);
        out_.corner_begin.assign(1, 0), out_.normal_begin.assign(1, 0);
        out_.corner_begin.reserve(out_.count + 1), out_.normal_begin.reserve(out_.count + 1),
            out_.rim_end.reserve(out_.count), out_.normal.reserve(out_.count);
        out_.colour_sum.assign(1, glm::u64vec3(0)), out_.colour_sum.reserve(out_.count + 1);
    }

    // Takes leaves from `begin` on until there are enough faces for long loops; returns the next leaf.
    uint32_t gather_leaves(uint32_t begin) {
        constexpr uint32_t kEnough = 256;
        uint32_t end = begin + 1;
        while (end < out_.count && out_.fan_begin[end] - out_.fan_begin[begin] < kEnough &&
               end - begin < kEnough)
            ++end;
        const uint32_t first = out_.fan_begin[begin], count = out_.fan_begin[end] - first;
        faces_.resize(count + kSpare);
        for (uint32_t i = begin; i < end; ++i)
            for (uint32_t k = out_.fan_begin[i]; k < out_.fan_begin[i + 1]; ++k) {
                const glm::dvec3 p = out_.at[out_.fan[k].x] - out_.at[i],
                                 q = out_.at[out_.fan[k].y] - out_.at[i];
                for (int axis = 0; axis < 3; ++axis)
                    faces_.p[axis][k - first] = p[axis], faces_.q[axis][k - first] = q[axis];
            }
        HWY_DYNAMIC_DISPATCH(ShareOut)(faces_, count);
        const size_t most =
            out_.corner_begin.back() + (kDisc + 1) * size_t(end - begin) + 4 * size_t(count) + kSpare;
        if (out_.corners.size() < most) out_.corners.resize(most + most / 4);
        for (uint32_t i = begin; i < end; ++i) gather_leaf(i, first);
        return end;
    }

    void gather_leaf(uint32_t i, uint32_t first_face) {
        corner_at_ = out_.corner_begin.back(), normal_at_ = out_.normal_begin.back();
        const uint32_t vertex = in_.points[in_.begin + i].vertex;
        glm::dvec3 normal = in_.cloud_radii.empty() ? add_faces(i, first_face) : add_disc(vertex);
        if (!in_.normals.empty()) {
            const glm::dvec3 given(in_.normals[vertex]);
            const double weight = glm::length(normal);
            if (glm::dot(given, given) > 0.25) {
                normal = given * (weight > 0 ? weight : 1.0);
                add_normal(in_.normals[vertex]);
            }
        }
        if (normal_at_ == out_.normal_begin.back()) add_normal(unit_or(normal, {0, 0, 1}));
        out_.rim_end.push_back(in_.cloud_radii.empty() ? rim_end_ : corner_at_);
        out_.corner_begin.push_back(corner_at_), out_.normal_begin.push_back(normal_at_);
        out_.normal.push_back(normal);
        out_.colour_sum.push_back(out_.colour_sum.back() +
                                  glm::u64vec3(in_.colours.empty() ? glm::u8vec3(0) : in_.colours[vertex]));
    }

    void add_corner(const glm::vec3& p) { out_.corners.set(corner_at_++, p); }
    void add_normal(const glm::vec3& n) { out_.face_normals.set(normal_at_++, n); }

    // Share corners and face normals of leaf i; returns the area-weighted normal.
    glm::dvec3 add_faces(uint32_t i, uint32_t first_face) {
        add_corner(glm::vec3(0));
        const uint32_t begin = out_.fan_begin[i], sibling = Surface::first_sibling(i);
        const size_t first = begin - first_face;
        HWY_DYNAMIC_DISPATCH(AddFaces)
        (faces_,
         {&out_.fan[begin], first, out_.valence(i), sibling,
          std::min(uint32_t(kMaxFanOut), out_.count - sibling), out_.is_closed[i] != 0},
         out_, corner_at_, rim_end_, normal_at_);
        glm::dvec3 sum(0);
        for (size_t k = first; k < first + out_.valence(i); ++k)
            sum += glm::dvec3(faces_.cross[0][k], faces_.cross[1][k], faces_.cross[2][k]);
        return sum;
    }

    // A bare point covers a disc across its normal (a ball's octahedron where it has none).
    glm::dvec3 add_disc(uint32_t vertex) {
        const double radius = double(in_.cloud_radii[vertex]) * in_.inverse_scale;
        const glm::vec3 n = in_.normals.empty() ? glm::vec3(0) : in_.normals[vertex];
        add_corner(glm::vec3(0));
        if (glm::dot(n, n) < 0.25f) {
            for (int axis = 0; axis < 3; ++axis)
                for (const double sign : {-1.0, 1.0}) {
                    glm::dvec3 p(0);
                    p[axis] += sign * radius;
                    add_corner(glm::vec3(p));
                }
            return glm::dvec3(0);
        }
        const Frame frame = frame_about(n);
        for (int k = 0; k < 8; ++k) {
            const double phi = k * 0.78539816339744831;
            add_corner(
                glm::vec3(radius / 0.92387953251128674 *
                          (std::cos(phi) * glm::dvec3(frame.t1) + std::sin(phi) * glm::dvec3(frame.t2))));
        }
        return glm::dvec3(n) * (radius * radius);
    }

    static constexpr size_t kDisc = 8;  // corners of a bare point's disc

    const SubtreeInput& in_;
    const glm::dvec3 base_;
    Surface out_;
    std::vector<uint32_t> strangers_;
    Faces faces_;
    uint32_t corner_at_ = 0, normal_at_ = 0;
    uint32_t rim_end_ = 0;
};

}  // namespace

Surface gather_surface(const SubtreeInput& input) {
    return Gatherer(input).run();
}

glm::vec3 unit_or(const glm::dvec3& v, const glm::vec3& otherwise) {
    const double length = glm::length(v);
    return length > 1e-300 && std::isfinite(length) ? glm::vec3(v / length) : otherwise;
}

}  // namespace splat
#endif
