#include "splat/disc.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/disc.cpp"
#include <hwy/foreach_target.h>
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "splat/vector3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 8>;
using V = hn::Vec<D>;

using V3 = Vector3<V>;

// How far up or down the faces (v, p, q), with normals n, go over the disc whose radius has this square.  Highest and
// lowest a face is where its edges enter or leave the disc or end in it, or where the rim is furthest up or down its plane.
// The disc is taken larger by what rounding may do.
HWY_INLINE V HeightOverDisc(const V3& v, const V3& p, const V3& q, const V3& n, V square) {
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), tiny = hn::Set(d, std::numeric_limits<float>::min());
    const auto cross = [&](V ax, V ay, V bx, V by) { return hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx)); };
    const auto from_axis = [&](const V3& t) { return hn::Add(hn::Mul(t.x, t.x), hn::Mul(t.y, t.y)); };
    const V reach = hn::Add(square, hn::Mul(hn::Max(from_axis(v), hn::Max(from_axis(p), from_axis(q))), hn::Set(d, 1e-6f)));
    const auto along_edge = [&](const V3& s, const V3& t) {
        const V dx = hn::Sub(t.x, s.x), dy = hn::Sub(t.y, s.y), dz = hn::Sub(t.z, s.z);
        const V inverse = hn::Div(one, hn::Max(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), tiny));
        const V middle = hn::Mul(hn::Neg(hn::Add(hn::Mul(s.x, dx), hn::Mul(s.y, dy))), inverse);
        const V area = cross(s.x, s.y, t.x, t.y);
        const V left = hn::Sub(reach, hn::Mul(hn::Mul(area, area), inverse));
        const V half = hn::Sqrt(hn::Mul(hn::Max(left, zero), inverse));
        const V first = hn::Max(zero, hn::Sub(middle, half)), last = hn::Min(one, hn::Add(middle, half));
        const V most = hn::Max(hn::Abs(hn::Add(s.z, hn::Mul(first, dz))), hn::Abs(hn::Add(s.z, hn::Mul(last, dz))));
        return hn::IfThenElseZero(hn::And(hn::Ge(left, zero), hn::Le(first, last)), most);
    };
    const V slope = hn::Sqrt(hn::Add(hn::Mul(n.x, n.x), hn::Mul(n.y, n.y)));
    const V outwards = hn::Div(hn::Sqrt(reach), hn::Max(slope, tiny));
    const V middle = Dot(n, v), tolerance = hn::Mul(reach, hn::Set(d, -1e-5f)), inverse = hn::Div(one, n.z);
    const auto at_rim = [&](V to) {
        const V x = hn::Mul(n.x, to), y = hn::Mul(n.y, to);
        const auto side = [&](const V3& s, const V3& t) {
            return hn::Ge(cross(hn::Sub(s.x, x), hn::Sub(s.y, y), hn::Sub(t.x, x), hn::Sub(t.y, y)), tolerance);
        };
        const V most = hn::Abs(hn::Mul(hn::Sub(middle, hn::Mul(to, hn::Mul(slope, slope))), inverse));
        return hn::IfThenElseZero(hn::And(side(v, p), hn::And(side(p, q), side(q, v))), most);
    };
    const V edges = hn::Max(along_edge(v, p), hn::Max(along_edge(p, q), along_edge(q, v)));
    const V corners = hn::Max(hn::Abs(v.z), hn::Max(hn::Abs(p.z), hn::Abs(q.z)));
    return hn::Min(corners, hn::Max(edges, hn::Max(at_rim(outwards), at_rim(hn::Neg(outwards)))));
}

// Some faces about a leaf, turned into its disc's frame, and the edges of their rim that cross the disc.
class Patch {
  public:
    static constexpr size_t kMost = 64;

    Patch(const Surface& surface, const glm::dvec3& centre, const Disc& disc)
        : surface_(surface), centre_(centre), disc_(disc) {}

    // Takes the faces about a leaf.  False where one of them is not seen from the normal's side.
    bool take_fan(uint32_t leaf) {
        const D d;
        const uint32_t begin = surface_.fan_begin[leaf], end = surface_.fan_begin[leaf + 1];
        const glm::vec3 vertex = turned(leaf);
        for (uint32_t i = begin; i < end; i += uint32_t(hn::Lanes(d))) {
            const auto turn = [&](const PointArrays& points, size_t corner) {
                const V3 p{hn::LoadU(d, &points.x[i]), hn::LoadU(d, &points.y[i]), hn::LoadU(d, &points.z[i])};
                store({hn::Add(Dot(Set3(d, disc_.frame.t1), p), hn::Set(d, vertex.x)), hn::Add(Dot(Set3(d, disc_.frame.t2), p), hn::Set(d, vertex.y)),
                       hn::Add(Dot(Set3(d, disc_.frame.n), p), hn::Set(d, vertex.z))}, corner, i - begin);
            };
            store(Set3(d, vertex), 0, i - begin);
            turn(surface_.fan_p, 1), turn(surface_.fan_q, 2);
        }
        count_ = end - begin;
        for (uint32_t k = 0; k < count_; ++k) {
            corner_[k] = {leaf, surface_.fan[begin + k].x, surface_.fan[begin + k].y};
            hwy::Prefetch(&surface_.fan[surface_.fan_begin[corner_[k].y]]);  // nearly all rims are crossed
        }
        return view(0);
    }

    // Adds the faces beyond the rim where it crosses the disc.  False where one of them is not there, or is not seen from
    // the normal's side, or there are too many.
    bool grow() {
        const size_t first = count_, edges = edges_;
        for (size_t k = 0; k < edges; ++k) {
            if (rim_[k].is_met || has_edge(first, rim_[k].to, rim_[k].from)) continue;  // the latter view() will see
            if (!add_beyond(k)) return false;
        }
        return view(first);
    }

    bool is_whole() const {
        for (size_t k = 0; k < edges_; ++k)
            if (!rim_[k].is_met) return false;
        return true;
    }
    // No face goes further up or down over the disc.
    float height() const { return height_; }
    // Bound on the distance of the disc's points beyond the rim from it: on the way out from the disc's centre, which is
    // over a face, they have passed it.
    float overhang() const {
        if (!is_over_centre_) return std::numeric_limits<float>::infinity();
        float most = 0;
        for (size_t k = 0; k < edges_; ++k)
            if (!rim_[k].is_met) most = std::max(most, rim_[k].overhang);
        return most;
    }

  private:
    static constexpr uint32_t kNone = ~0u;
    struct Edge {
        uint32_t from, to;
        uint16_t face;   // that has it, from this corner of it
        uint8_t corner;
        bool is_met;     // the face on its other side was taken
        float overhang;
    };

    void store(const V3& p, size_t corner, size_t i) {
        const D d;
        hn::StoreU(p.x, d, &at_[corner][0][i]), hn::StoreU(p.y, d, &at_[corner][1][i]), hn::StoreU(p.z, d, &at_[corner][2][i]);
    }
    V3 load(size_t corner, size_t i) const {
        const D d;
        return {hn::LoadU(d, &at_[corner][0][i]), hn::LoadU(d, &at_[corner][1][i]), hn::LoadU(d, &at_[corner][2][i])};
    }

    glm::vec3 turned(uint32_t corner) const {
        const glm::vec3 p(surface_.at[corner] - centre_);
        return {glm::dot(disc_.frame.t1, p), glm::dot(disc_.frame.t2, p), glm::dot(disc_.frame.n, p)};
    }

    // Adds the face that has a rim's edge the other way round.
    bool add_beyond(size_t edge) {
        const Edge& e = rim_[edge];
        const uint32_t third = beyond(e);
        if (third == kNone || count_ == kMost) return false;
        rim_[edge].is_met = true;
        const size_t from = e.corner, to = (from + 1) % 3;
        const glm::vec3 at = turned(third);
        for (size_t axis = 0; axis < 3; ++axis) {
            at_[0][axis][count_] = at_[to][axis][e.face], at_[1][axis][count_] = at_[from][axis][e.face];
            at_[2][axis][count_] = at[int(axis)];
        }
        corner_[count_++] = {e.to, e.from, third};
        return true;
    }

    // The third corner of the face that has an edge the other way round: about the corner where the edge begins, its p
    // where q is the edge's end; about the corner where it ends, its q where p is the edge's beginning.
    uint32_t beyond(const Edge& e) const {
        const uint32_t third = partner(e.from, e.to, 0xaau);
        return third != kNone ? third : partner(e.to, e.from, 0x55u);
    }

    // The other corner of the face about a corner that has `corner` where the bits of the mask are set.
    uint32_t partner(uint32_t about, uint32_t corner, unsigned mask) const {
        const hn::CappedTag<uint32_t, 8> du;
        const uint32_t begin = surface_.fan_begin[about], numbers = 2 * surface_.valence(about);
        const uint32_t* const fan = &surface_.fan[begin].x;
        for (uint32_t at = 0; at < numbers; at += uint32_t(hn::Lanes(du))) {
            const auto same = hn::And(hn::FirstN(du, numbers - at), hn::Eq(hn::LoadU(du, fan + at), hn::Set(du, corner)));
            uint8_t bits[8] = {};
            hn::StoreMaskBits(du, same, bits);
            if (const unsigned found = bits[0] & mask) return fan[(at + unsigned(__builtin_ctz(found))) ^ 1u];
        }
        return kNone;
    }

    bool has_edge(size_t first, uint32_t from, uint32_t to) const {
        for (size_t k = first; k < count_; ++k)
            if (corner_[k].z == to || corner_[k].z == from)
                for (int c = 0; c < 3; ++c)
                    if (corner_[k][c] == from && corner_[k][(c + 1) % 3] == to) return true;
        return false;
    }

    // Looks at the faces from `first` on.  On the rim are their edges from corner 1 to 2; of faces that were added also
    // those from 2 to 0.
    bool view(size_t first) {
        const D d;
        const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), r = hn::Set(d, disc_.radius), square = hn::Set(d, disc_.radius * disc_.radius * 1.0001f);
        for (size_t i = first; i < count_; i += hn::Lanes(d)) {
            const auto valid = hn::FirstN(d, count_ - i);
            const V3 v = load(0, i), p = load(1, i), q = load(2, i);
            const V3 a{hn::Sub(p.x, v.x), hn::Sub(p.y, v.y), hn::Sub(p.z, v.z)}, b{hn::Sub(q.x, v.x), hn::Sub(q.y, v.y), hn::Sub(q.z, v.z)};
            const V3 n{hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
                       hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
            if (!hn::AllTrue(d, hn::Or(hn::Not(valid), hn::Gt(n.z, zero)))) return false;
            // Square of the distance of an edge from the centre, seen along the normal.
            const auto square_to = [&](const V3& s, const V3& t) {
                const V dx = hn::Sub(t.x, s.x), dy = hn::Sub(t.y, s.y);
                const V all = hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy));
                const V along = hn::Neg(hn::Add(hn::Mul(s.x, dx), hn::Mul(s.y, dy)));
                const V at = hn::Min(one, hn::Max(zero, hn::IfThenElseZero(hn::Gt(all, zero), hn::Div(along, all))));
                const V x = hn::Add(s.x, hn::Mul(at, dx)), y = hn::Add(s.y, hn::Mul(at, dy));
                return hn::Add(hn::Mul(x, x), hn::Mul(y, y));
            };
            const auto cross = [&](const V3& s, const V3& t) { return hn::Sub(hn::Mul(s.x, t.y), hn::Mul(s.y, t.x)); };
            const auto around = hn::And(valid, hn::And(hn::Ge(cross(v, p), zero), hn::And(hn::Ge(cross(p, q), zero), hn::Ge(cross(q, v), zero))));
            is_over_centre_ |= !hn::AllFalse(d, around);
            height_ = std::max(height_, hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(valid, HeightOverDisc(v, p, q, n, square)))));
            const auto take_rim = [&](V to, const V3& s, const V3& t, int corner) {
                const auto crossing = hn::And(valid, hn::Le(to, square));
                if (hn::AllFalse(d, crossing)) return;
                const V beyond = hn::Max(zero, hn::Sub(r, hn::Sqrt(to))), off = hn::Max(hn::Abs(s.z), hn::Abs(t.z));
                alignas(32) float overhang[8];
                hn::Store(hn::Sqrt(hn::Add(hn::Mul(beyond, beyond), hn::Mul(off, off))), d, overhang);
                uint8_t bits[8] = {};
                hn::StoreMaskBits(d, crossing, bits);
                for (uint32_t m = bits[0]; m; m &= m - 1) {
                    const auto lane = size_t(__builtin_ctz(m));
                    const glm::u32vec3& face = corner_[i + lane];
                    meet({face[corner], face[(corner + 1) % 3], uint16_t(i + lane), uint8_t(corner), false, overhang[lane]});
                }
            };
            take_rim(square_to(p, q), p, q, 1);
            if (first > 0) take_rim(square_to(q, v), q, v, 2);
        }
        return true;
    }

    // An edge of the rim crosses the disc: it meets its reverse, or waits for it.
    void meet(const Edge& edge) {
        for (size_t k = 0; k < edges_; ++k)
            if (rim_[k].from == edge.to && rim_[k].to == edge.from && !rim_[k].is_met) {
                rim_[k].is_met = true;
                return;
            }
        rim_[edges_++] = edge;
    }

    const Surface& surface_;
    const glm::dvec3 centre_;
    const Disc& disc_;
    size_t count_ = 0;
    alignas(64) float at_[3][3][kMost + 8];  // corner, axis, face
    glm::u32vec3 corner_[kMost];
    Edge rim_[2 * kMost];  // a face that was added brings two, and the first faces one each
    size_t edges_ = 0;
    float height_ = 0;
    bool is_over_centre_ = false;
};

// Corners of the cells on the unit disc: the centre, and three rings of 16, the outermost drawn round the
// circle.  The first corners of each ring are repeated at its end, so that corner k + 1 can be loaded.
constexpr int kSectors = 16, kRing = kSectors + 16, kRings = 3;
using Sectors = hn::CappedTag<float, kSectors>;
struct Rings {
    float x[kRings][kSectors], y[kRings][kSectors];
    Rings() {
        const double radius[kRings] = {0.4, 0.72, 1.0001 / std::cos(3.14159265358979 / kSectors)};
        for (int r = 0; r < kRings; ++r)
            for (int k = 0; k < kSectors; ++k) {
                const double phi = 2 * 3.14159265358979 * k / kSectors;
                x[r][k] = float(radius[r] * std::cos(phi)), y[r][k] = float(radius[r] * std::sin(phi));
            }
    }
};

// A cell cut into 4 x 4, by its corners and all between them.
constexpr int kCuts = 4, kGrid = (kCuts + 1) * (kCuts + 1), kGridRoom = kGrid + 16;
struct CellGrid {
    float x[kGridRoom], y[kGridRoom];
    float x_middle, y_middle, reach;  // no point of the cell is further from its middle

    CellGrid(const Rings& rings, float radius, int ring, int sector) {
        const auto corner = [&](int r, int k) {
            return r < 0 ? glm::vec2(0) : radius * glm::vec2(rings.x[r][k % kSectors], rings.y[r][k % kSectors]);
        };
        const glm::vec2 a = corner(ring - 1, sector), b = corner(ring - 1, sector + 1), c = corner(ring, sector), e = corner(ring, sector + 1);
        for (int k = 0; k < kGridRoom; ++k) {
            const int at = std::min(k, kGrid - 1);
            const float s = float(at % (kCuts + 1)) / kCuts, t = float(at / (kCuts + 1)) / kCuts;
            const glm::vec2 p = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * e);
            x[k] = p.x, y[k] = p.y;
        }
        const glm::vec2 middle = 0.25f * (a + b + c + e);
        x_middle = middle.x, y_middle = middle.y, reach = 0;
        for (const glm::vec2& p : {a, b, c, e}) reach = std::max(reach, glm::length(p - middle));
    }
};

// Bound on the distance of the disc's points from the nearest of some convex parts, each with its own error: cell by cell
// the part whose distance, at the cell's corners, is least.  distance(part, x, y) is from (x, y, 0).
template <class Distance, class Error>
class Cells {
  public:
    Cells(float radius, size_t count, const Distance& distance, const Error& error)
        : radius_(radius), count_(count), distance_(distance), error_(error) {
        for (auto& ring : bound_) std::fill(ring, ring + kSectors, std::numeric_limits<float>::infinity());
    }

    // Bounds up to `enough` are not made smaller.
    HWY_INLINE float bound(float enough) {
        for (size_t part = 0; part < count_ && (part % 8 != 0 || worst() > enough); ++part) take(part);
        return worst();
    }

    // The same, with the worst cells cut finer.
    float fine_bound(float enough) {
        bound(enough);
        bool is_fine[kRings * kSectors] = {};
        float* const cells = bound_[0];
        for (;;) {
            float* const at = std::max_element(cells, cells + kRings * kSectors);
            const auto cell = int(at - cells);
            if (is_fine[cell] || !std::isfinite(*at) || *at <= enough) return *at;
            is_fine[cell] = true;
            const float known = *at;
            *at = cut(cell, known);
            if (*at > 0.98f * known) return known;
        }
    }

  private:
    using Sector = hn::Vec<Sectors>;

    static const Rings& rings() {
        static const Rings rings;
        return rings;
    }

    void take(size_t part) {
        const Sectors d;
        float corner[kRings][kRing];
        const int lanes = int(hn::Lanes(d));
        const Sector scale = hn::Set(d, radius_), error = hn::Set(d, error_(part));
        for (int r = 0; r < kRings; ++r) {
            for (int k = 0; k < kSectors; k += lanes)
                hn::StoreU(distance_(part, hn::Mul(scale, hn::LoadU(d, rings().x[r] + k)), hn::Mul(scale, hn::LoadU(d, rings().y[r] + k))), d, corner[r] + k);
            hn::StoreU(hn::LoadU(d, corner[r]), d, corner[r] + kSectors);
        }
        const Sector middle = distance_(part, hn::Zero(d), hn::Zero(d));
        for (int k = 0; k < kSectors; k += lanes) {
            Sector inner = middle;
            for (int r = 0; r < kRings; ++r) {
                const Sector outer = hn::Max(hn::LoadU(d, corner[r] + k), hn::LoadU(d, corner[r] + k + 1));
                hn::StoreU(hn::Min(hn::LoadU(d, bound_[r] + k), hn::Add(error, hn::Max(inner, outer))), d, bound_[r] + k);
                inner = outer;
            }
        }
    }

    float worst() const {
        const Sectors d;
        auto worst = hn::Zero(d);
        for (const auto& ring : bound_)
            for (size_t k = 0; k < kSectors; k += hn::Lanes(d)) worst = hn::Max(worst, hn::LoadU(d, ring + k));
        return hn::GetLane(hn::MaxOfLanes(d, worst));
    }

    // The bound of one cell, by its 16 parts.
    float cut(int cell, float known) const {
        const Sectors d;
        const CellGrid grid(rings(), radius_, cell / kSectors, cell % kSectors);
        float bound[kCuts * kCuts];
        std::fill(bound, bound + kCuts * kCuts, known);
        for (size_t part = 0; part < count_; ++part) {
            const float middle = hn::GetLane(distance_(part, hn::Set(d, grid.x_middle), hn::Set(d, grid.y_middle)));
            if (middle - grid.reach + error_(part) >= known) continue;
            float at[kGridRoom];
            for (int k = 0; k < kGrid; k += int(hn::Lanes(d))) hn::StoreU(distance_(part, hn::LoadU(d, grid.x + k), hn::LoadU(d, grid.y + k)), d, at + k);
            for (int k = 0; k < kCuts * kCuts; ++k) {
                const float* corner = at + k / kCuts * (kCuts + 1) + k % kCuts;
                const float most = std::max(std::max(corner[0], corner[1]), std::max(corner[kCuts + 1], corner[kCuts + 2]));
                bound[k] = std::min(bound[k], error_(part) + most);
            }
        }
        return *std::max_element(bound, bound + kCuts * kCuts);
    }

    const float radius_;
    const size_t count_;
    const Distance& distance_;
    const Error& error_;
    float bound_[kRings][kSectors];
};

// Discs in another disc's frame: centre (relative to the other's), normal, radius and error.
struct Discs {
    static constexpr size_t kMost = 64;
    size_t count;
    alignas(64) float x[kMost], y[kMost], z[kMost], nx[kMost], ny[kMost], nz[kMost], radius[kMost], error[kMost];
};

void TurnDiscs(const Node& node, std::span<const Node* const> parts, Discs& discs) {
    const D d;
    discs.count = std::min(parts.size(), Discs::kMost);
    for (size_t k = 0; k < discs.count; ++k) {
        const Node& c = *parts[k];
        discs.x[k] = float(c.centre.x - node.centre.x), discs.y[k] = float(c.centre.y - node.centre.y), discs.z[k] = float(c.centre.z - node.centre.z);
        discs.nx[k] = c.normal.x, discs.ny[k] = c.normal.y, discs.nz[k] = c.normal.z;
        discs.radius[k] = c.radius, discs.error[k] = c.error;
    }
    const Frame frame = frame_about(node.normal);
    const auto turn = [&](float* x, float* y, float* z) {
        const V3 p{hn::Load(d, x), hn::Load(d, y), hn::Load(d, z)};
        hn::Store(Dot(Set3(d, frame.t1), p), d, x), hn::Store(Dot(Set3(d, frame.t2), p), d, y), hn::Store(Dot(Set3(d, frame.n), p), d, z);
    };
    for (size_t k = 0; k < discs.count; k += hn::Lanes(d)) turn(discs.x + k, discs.y + k, discs.z + k), turn(discs.nx + k, discs.ny + k, discs.nz + k);
}

float NestedError(const Node& node, std::span<const Node* const> parts, bool is_fine) {
    using S = hn::Vec<Sectors>;
    const Sectors d;
    Discs discs;
    TurnDiscs(node, parts, discs);
    const auto distance = [&](size_t k, S px, S py) {
        const S x = hn::Sub(px, hn::Set(d, discs.x[k])), y = hn::Sub(py, hn::Set(d, discs.y[k])), z = hn::Set(d, -discs.z[k]);
        const S along = hn::Add(hn::Add(hn::Mul(x, hn::Set(d, discs.nx[k])), hn::Mul(y, hn::Set(d, discs.ny[k]))), hn::Mul(z, hn::Set(d, discs.nz[k])));
        const S square = hn::Mul(along, along);
        const S all = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
        const S across = hn::Sqrt(hn::Max(hn::Zero(d), hn::Sub(all, square)));
        const S beyond = hn::Max(hn::Zero(d), hn::Sub(across, hn::Set(d, discs.radius[k])));
        return hn::Sqrt(hn::Add(hn::Mul(beyond, beyond), square));
    };
    const auto error = [&](size_t k) { return discs.error[k]; };
    // No smaller error is told apart.
    const float enough = node.radius * kErrorOfRadius[flatness_code(node)][0];
    Cells cells(node.radius, discs.count, distance, error);
    return is_fine ? cells.fine_bound(enough) : cells.bound(enough);
}

// Nodes [first, first + count) of each group whose spheres touch the one of `node`.
void Touching(const Spheres& spheres, std::span<const NodeRange> groups, uint32_t node, std::vector<uint32_t>& out) {
    const D d;
    const V x = hn::Set(d, spheres.x[node]), y = hn::Set(d, spheres.y[node]), z = hn::Set(d, spheres.z[node]), radius = hn::Set(d, spheres.radius[node]);
    for (const NodeRange& group : groups)
        for (uint32_t k = 0; k < group.count; k += uint32_t(hn::Lanes(d))) {
            const size_t i = group.first + k;
            const V3 to{hn::Sub(hn::LoadU(d, &spheres.x[i]), x), hn::Sub(hn::LoadU(d, &spheres.y[i]), y), hn::Sub(hn::LoadU(d, &spheres.z[i]), z)};
            const V reach = hn::Add(hn::LoadU(d, &spheres.radius[i]), radius);
            uint8_t bits[8] = {};
            hn::StoreMaskBits(d, hn::And(hn::FirstN(d, group.count - k), hn::Lt(Dot(to, to), hn::Mul(reach, reach))), bits);
            for (unsigned m = bits[0]; m; m &= m - 1) out.push_back(uint32_t(i) + unsigned(__builtin_ctz(m)));
        }
}

// Distance from (px, py, 0) to the triangle a, b, c: to its plane where the foot is inside, else to the edges.
template <class D, class V = hn::Vec<D>>
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

// Bound on the distance of the disc's points from the faces about the leaf and about its neighbours that are not far from
// the disc (of more than kMost, the first ones).
float NearFacesError(const Surface& surface, uint32_t leaf, const glm::dvec3& centre, const Disc& disc) {
    constexpr size_t kMost = 256;
    const auto turned = [&](uint32_t corner) {
        const glm::vec3 x(surface.at[corner] - centre);
        return glm::vec3(glm::dot(disc.frame.t1, x), glm::dot(disc.frame.t2, x), glm::dot(disc.frame.n, x)) / disc.radius;  // of order 1: squares stay in range
    };
    uint32_t pivots[kMost] = {leaf};
    size_t count = 1;
    const auto is_among = [&](uint32_t corner, size_t first) { return std::find(pivots, pivots + first, corner) != pivots + first; };
    for (uint32_t k = surface.fan_begin[leaf]; k < surface.fan_begin[leaf + 1]; ++k)
        for (const uint32_t corner : {surface.fan[k].x, surface.fan[k].y})
            if (count < kMost && !is_among(corner, count) && glm::length(turned(corner)) < 2) pivots[count++] = corner;
    glm::vec3 v[kMost], p[kMost], q[kMost];
    size_t taken = 0;
    for (size_t n = 0; n < count; ++n)
        for (uint32_t k = surface.fan_begin[pivots[n]]; k < surface.fan_begin[pivots[n] + 1] && taken < kMost; ++k) {
            const glm::u32vec2 face = surface.fan[k];
            if (is_among(face.x, n) || is_among(face.y, n)) continue;
            v[taken] = turned(pivots[n]), p[taken] = turned(face.x), q[taken] = turned(face.y);
            ++taken;
        }
    const auto distance = [&](size_t k, auto x, auto y) { return DistanceToTriangle(Sectors(), x, y, v[k], p[k], q[k]); };
    const auto error = [](size_t) { return 0.0f; };
    return disc.radius * Cells(1.0f, taken, distance, error).fine_bound(kErrorOfRadius[disc.flatness][0]);
}

// The faces about the leaf are taken, and then those beyond their rim, until no edge of the rim crosses the disc.  If all
// of them are seen from the normal's side, their projection covers the whole disc (its degree over the disc is constant,
// and positive at the vertex), so that over each point of the disc there is surface, no further up or down than the
// faces that meet the disc go.  Where they fold over or end, it is the distance to the faces near it.
float LeafError(const Surface& surface, uint32_t leaf, const glm::dvec3& centre, const Disc& disc) {
    const auto by_near_faces = [&] { return NearFacesError(surface, leaf, centre, disc); };
    if (!surface.is_closed[leaf] || surface.valence(leaf) > Patch::kMost / 2) return by_near_faces();
    Patch patch(surface, centre, disc);
    if (!patch.take_fan(leaf)) return by_near_faces();
    while (!patch.is_whole()) {
        // Faces further out matter only where they make the code smaller.
        const float bound = std::max(patch.height(), patch.overhang());
        const auto code = [&](float error) { return encode_error(error, disc.radius, disc.flatness); };
        if (code(bound) == code(patch.height())) return bound;
        if (!patch.grow()) return std::min(bound, by_near_faces());
    }
    return patch.height();
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(NestedError);
HWY_EXPORT(LeafError);
HWY_EXPORT(Touching);

float leaf_error(const Surface& surface, uint32_t leaf, const glm::dvec3& centre, const Disc& disc) {
    return HWY_DYNAMIC_DISPATCH(LeafError)(surface, leaf, centre, disc);
}

float nested_error(const Node& node, std::span<const Node* const> parts, bool is_fine) {
    return HWY_DYNAMIC_DISPATCH(NestedError)(node, parts, is_fine);
}

void touching(const Spheres& spheres, std::span<const NodeRange> groups, uint32_t node, std::vector<uint32_t>& out) {
    HWY_DYNAMIC_DISPATCH(Touching)(spheres, groups, node, out);
}

}  // namespace splat
#endif
