#include "splat/build/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/build/fit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/decode-inl.h"

#ifndef QS_SPLAT_FIT_ONCE
#define QS_SPLAT_FIT_ONCE
namespace splat {
namespace {

// Beyond these a level is inserted.  An inner node that is coded too large makes its children small against
// it, and them too large in turn.
constexpr float kMaxLeafInflation = 2.5f, kMaxInnerInflation = 1.6f;
constexpr float kThinWeight =
    0.7f;  // what is minimised: R (1 + 0.7 rho); more makes leaves rounder and larger
constexpr float kMinRadius = 1e-12f;  // model units; points closer together than this are one
constexpr float kRoundUp = 1.0001f;   // over the float rounding of decode and cover

// What the stages of a fit hand on, a lane a child.
struct FitState {
    alignas(32) Lanes<float> normal[3], t1[3], t2[3], low[3], high[3], ideal[3], smallest;
    alignas(32) Lanes<uint32_t> normal_code, place;
    alignas(32) Lanes<float> radius_level;
};

struct Choice {
    uint32_t place = kRadiusLevels - 1u, shape = 3;
    float cost = std::numeric_limits<float>::infinity();
};

uint32_t encode_cone(float least_dot, int parent_cone) {
    const int base = parent_cone < 0 ? 0 : parent_cone;
    for (uint32_t code = 0; code < 3; ++code) {
        const int index = decode_cone(int(code), parent_cone);
        if (index >= base && kConeCos[index] <= least_dot - 2e-6f) return code;
    }
    return 3;
}

}  // namespace
}  // namespace splat
#endif  // QS_SPLAT_FIT_ONCE

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kLanes>;
using DU = hn::Rebind<uint32_t, D>;
using V = hn::Vec<D>;
using V3 = Vector3<V>;

constexpr size_t kCentres = 16;  // that are tried at a time
using Wide = hn::CappedTag<float, kCentres>;
using W = hn::Vec<Wide>;

// The best of the four codes about each direction.
void EncodeNormals(const V3& wanted, const Frame& parent, int cone, size_t lane, FitState& state) {
    const D d;
    const DU du;
    const hn::RebindToSigned<D> di;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    V x, y;  // where in [-1, 1]^2 the direction lies before rounding
    if (cone < 0) {
        const V sum = hn::Add(hn::Add(hn::Abs(wanted.x), hn::Abs(wanted.y)), hn::Abs(wanted.z));
        const V px = hn::Div(wanted.x, sum), py = hn::Div(wanted.y, sum);
        const auto below = hn::Lt(wanted.z, zero);
        x = hn::IfThenElse(below, hn::CopySign(hn::Sub(one, hn::Abs(py)), px), px);
        y = hn::IfThenElse(below, hn::CopySign(hn::Sub(one, hn::Abs(px)), py), py);
    } else {
        const V w = hn::Mul(hn::Add(one, hn::Max(Dot(wanted, Set3(d, parent.n)), hn::Set(d, -0.99f))),
                            hn::Set(d, kConeTan[cone]));
        x = hn::Div(Dot(wanted, Set3(d, parent.t1)), w), y = hn::Div(Dot(wanted, Set3(d, parent.t2)), w);
    }
    const auto step = [&](V p) {
        const V scaled =
            hn::Add(hn::Mul(hn::Min(one, hn::Max(hn::Neg(one), p)), hn::Set(d, 15.0f)), hn::Set(d, 15.0f));
        return hn::BitCast(du, hn::Min(hn::ConvertTo(di, scaled), hn::Set(di, kNormalSteps - 2)));
    };
    const auto steps = hn::Set(du, uint32_t(kNormalSteps));
    const auto low = hn::Add(hn::Mul(step(y), steps), step(x));
    auto best = low;
    V best_dot = hn::Set(d, -2.0f);
    V3 normal{zero, zero, one};
    const FrameLanes<V> parent_frame{Set3(d, parent.t1), Set3(d, parent.t2), Set3(d, parent.n)};
    const V cone_tan = hn::Set(d, kConeTan[std::max(cone, 0)]);
    const auto any_direction = hn::Lt(hn::Set(d, float(cone)), zero);
    for (uint32_t k = 0; k < 4; ++k) {
        const auto code = hn::Add(low, hn::Set(du, k / 2 * uint32_t(kNormalSteps) + k % 2));
        const V3 n = DecodeNormal(d, code, parent_frame, cone_tan, any_direction);
        const V dot = Dot(n, wanted);
        const auto better = hn::Gt(dot, best_dot);
        best_dot = hn::IfThenElse(better, dot, best_dot),
        best = hn::IfThenElse(hn::RebindMask(du, better), code, best);
        normal = {hn::IfThenElse(better, n.x, normal.x), hn::IfThenElse(better, n.y, normal.y),
                  hn::IfThenElse(better, n.z, normal.z)};
    }
    hn::Store(best, du, &state.normal_code[lane]);
    const FrameLanes<V> frame = FrameAbout(d, normal);
    const auto store = [&](const V3& v, Lanes<float>* to) {
        hn::Store(v.x, d, &to[0][lane]), hn::Store(v.y, d, &to[1][lane]), hn::Store(v.z, d, &to[2][lane]);
    };
    store(frame.n, state.normal), store(frame.t1, state.t1), store(frame.t2, state.t2);
}

V3 Load3(const Lanes<float>* from, size_t lane) {
    const D d;
    return {hn::Load(d, &from[0][lane]), hn::Load(d, &from[1][lane]), hn::Load(d, &from[2][lane])};
}

struct Extremes {
    V low[5], high[5];
    void take(const V3& p) {
        const V along[5] = {p.x, p.y, p.z, hn::Add(p.x, p.y), hn::Sub(p.x, p.y)};
        for (int k = 0; k < 5; ++k) low[k] = hn::Min(low[k], along[k]), high[k] = hn::Max(high[k], along[k]);
    }
};
Extremes NoExtremes() {
    const D d;
    Extremes e;
    for (int k = 0; k < 5; ++k) e.low[k] = hn::Inf(d), e.high[k] = hn::Neg(hn::Inf(d));
    return e;
}

// Turns each child's points into its own frame, in place; finds the middle of the smallest circle across,
// nearly, and of the thickness, the box about them, and the radius of the sphere about that middle.
void TurnPoints(GroupContent& content, float parent_radius, size_t lane, FitState& state) {
    const D d;
    const V3 t1 = Load3(state.t1, lane), t2 = Load3(state.t2, lane), n = Load3(state.normal, lane);
    Extremes e = NoExtremes();
    for (size_t at = lane; at < content.rows * kLanes; at += kLanes) {
        const V3 p{hn::LoadU(d, &content.x[at]), hn::LoadU(d, &content.y[at]), hn::LoadU(d, &content.z[at])};
        const V3 turned{Dot(t1, p), Dot(t2, p), Dot(n, p)};
        hn::StoreU(turned.x, d, &content.x[at]), hn::StoreU(turned.y, d, &content.y[at]),
            hn::StoreU(turned.z, d, &content.z[at]);
        e.take(turned);
    }
    const V half = hn::Set(d, 0.5f);
    const auto middle = [&](int k) { return hn::Mul(half, hn::Add(e.low[k], e.high[k])); };
    const V sum = middle(3), difference = middle(4);
    const V3 ideal{hn::Mul(half, hn::Add(middle(0), hn::Mul(half, hn::Add(sum, difference)))),
                   hn::Mul(half, hn::Add(middle(1), hn::Mul(half, hn::Sub(sum, difference)))), middle(2)};
    V most = hn::Zero(d);
    for (size_t at = lane; at < content.rows * kLanes; at += kLanes) {
        const V3 p{hn::Sub(hn::LoadU(d, &content.x[at]), ideal.x),
                   hn::Sub(hn::LoadU(d, &content.y[at]), ideal.y),
                   hn::Sub(hn::LoadU(d, &content.z[at]), ideal.z)};
        most = hn::Max(most, Dot(p, p));
    }
    hn::Store(hn::Max(hn::Sqrt(most), hn::Set(d, std::min(kMinRadius, parent_radius))), d,
              &state.smallest[lane]);
    for (int k = 0; k < 3; ++k)
        hn::Store(e.low[k], d, &state.low[k][lane]), hn::Store(e.high[k], d, &state.high[k][lane]);
    hn::Store(ideal.x, d, &state.ideal[0][lane]), hn::Store(ideal.y, d, &state.ideal[1][lane]),
        hn::Store(ideal.z, d, &state.ideal[2][lane]);
}

float LeastDot(const PointArrays& vectors, size_t begin, size_t end, const glm::vec3& n) {
    const D d;
    const V3 normal = Set3(d, n);
    V least = hn::Set(d, 1.0f);
    for (size_t i = begin; i < end; i += hn::Lanes(d)) {
        const V dot = Dot(normal, V3{hn::LoadU(d, &vectors.x[i]), hn::LoadU(d, &vectors.y[i]),
                                     hn::LoadU(d, &vectors.z[i])});
        least = hn::IfThenElse(hn::FirstN(d, end - i), hn::Min(least, dot), least);
    }
    return hn::GetLane(hn::MinOfLanes(d, least));
}

// Where the centre's lattice has its steps, by level.
struct Lattice {
    float across[kAcrossSteps], along[kAlongSteps];
    alignas(64) float limit[kRadiusLevels];
    Lattice() {
        for (int k = 0; k < kAcrossSteps; ++k) across[k] = across_step(k);
        for (int k = 0; k < kAlongSteps; ++k) along[k] = along_step(k);
        for (int k = 0; k < kRadiusLevels; ++k) limit[k] = centre_limit(k);
    }
};

// The search for one child's centre, radius and flatness: over a lattice of centres, a lane a centre.
class Search {
  public:
    Search(const GroupContent& content, const FitState& state, size_t child, float parent_radius)
        : u_(&content.x[child]),
          v_(&content.y[child]),
          w_(&content.z[child]),
          points_(content.points[child]),
          low_(state.low[0][child], state.low[1][child], state.low[2][child]),
          high_(state.high[0][child], state.high[1][child], state.high[2][child]),
          ideal_(state.ideal[0][child], state.ideal[1][child], state.ideal[2][child]),
          smallest_(state.smallest[child]),
          parent_radius_(parent_radius) {}

    Choice nearest() {
        find_steps();
        for (int level = 0; level < kRadiusLevels; ++level) {
            const float radius = kRadius[level] * parent_radius_;
            const bool is_last = level == kRadiusLevels - 1;
            if (radius < smallest_ && !is_last) continue;
            if (radius * (1.0f + kThinWeight * kFlatness[0]) >= best_.cost) break;
            // Two levels at a time: what the larger one adds where the smaller one has a cover is not the
            // cheapest.
            const int next = is_last ? level : level + 1;
            try_cells({cell_at(level), cell_at(next)});
            level = next;
        }
        return best_;
    }

    // For the few leaves at the rim of their parent whose best centre is not the nearest to the ideal one:
    // the whole lattice, up to the first level that has a cover.
    Choice anywhere() {
        for (int level = 0; level < kRadiusLevels - 1; ++level) {
            const Lattice& steps = lattice();
            const float radius = kRadius[level] * parent_radius_, limit = steps.limit[level] * parent_radius_;
            if (radius < smallest_) continue;
            // Can a centre reach both ends of the points along an axis?  It is between these steps, or was
            // pulled back towards 0.
            const auto reaches = [&](int axis, float from, float to) {
                return high_[axis] - radius <= std::max(0.0f, to * limit) &&
                       std::min(0.0f, from * limit) <= low_[axis] + radius;
            };
            for (int a = 0; a < kAcrossSteps - 1; ++a) {
                if (!reaches(0, steps.across[a], steps.across[a + 1])) continue;
                for (int b = 0; b < kAcrossSteps - 1; ++b) {
                    if (!reaches(1, steps.across[b], steps.across[b + 1])) continue;
                    for (int c = 0; c < kAlongSteps; c += 4)
                        if (reaches(2, steps.along[c], steps.along[c + 3]))
                            try_cells({Cell{level, a, b, c}, Cell{level, a, b, c + 2}});
                }
            }
            if (int(best_.place & 15u) == level) break;
        }
        return best_;
    }

  private:
    // Eight centres about one place: these steps and the next ones.
    struct Cell {
        int level, a, b, c;
    };
    Cell cell_at(int level) const { return {level, a_[level], b_[level], c_[level]}; }

    // For each level the step at or below the ideal centre along each axis, so that it and the next lie about
    // it.
    void find_steps() {
        const D d;
        const hn::RebindToSigned<D> di;
        const auto steps = [&](float x, V scale, int count, float per_limit, float linear, int32_t* out) {
            const V at = hn::Mul(hn::Set(d, x), scale);
            const V a = hn::Min(hn::Abs(at), hn::Set(d, 1.0f));
            const V root =
                hn::Sqrt(hn::Add(hn::Set(d, linear * linear), hn::Mul(hn::Set(d, 4 * (1 - linear)), a)));
            const V u =
                hn::Mul(hn::Sub(root, hn::Set(d, linear)), hn::Set(d, per_limit / (2 * (1 - linear))));
            const V index = hn::Add(hn::CopySign(u, at), hn::Set(d, 0.5f * float(count - 1) + 1e-3f));
            hn::Store(hn::Min(hn::Max(hn::ConvertTo(di, index), hn::Zero(di)), hn::Set(di, count - 2)), di,
                      out);
        };
        for (size_t level = 0; level < kRadiusLevels; level += hn::Lanes(d)) {
            const V reach = hn::Mul(hn::Load(d, &lattice().limit[level]), hn::Set(d, parent_radius_));
            const V scale =
                hn::Div(hn::Set(d, 1.0f), hn::Max(reach, hn::Set(d, std::numeric_limits<float>::min())));
            steps(ideal_.x, scale, kAcrossSteps, 5, kAcrossLinear, a_ + level);
            steps(ideal_.y, scale, kAcrossSteps, 5, kAcrossLinear, b_ + level);
            steps(ideal_.z, scale, kAlongSteps, 16, kAlongLinear, c_ + level);
        }
    }

    // Two cells, a lane a centre: of those that hold the points the cheapest.
    void try_cells(const std::array<Cell, 2>& cells) {
        const Wide d;
        alignas(
            64) static constexpr float kHighA[kCentres] = {0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1},
                                       kHighB[kCentres] = {0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1},
                                       kHighC[kCentres] = {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1},
                                       kSecond[kCentres] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};
        for (size_t lane = 0; lane < kCentres; lane += hn::Lanes(d)) {
            const auto is_set = [&](const float* flags)
                                    HWY_ATTR { return hn::Gt(hn::Load(d, flags + lane), hn::Zero(d)); };
            const auto is_second = is_set(kSecond);
            const auto of_cell = [&](float first, float second) HWY_ATTR {
                return hn::IfThenElse(is_second, hn::Set(d, second), hn::Set(d, first));
            };
            const auto pick = [&](const float* high, const float* step, int first, int second) HWY_ATTR {
                return hn::IfThenElse(is_set(high), of_cell(step[first + 1], step[second + 1]),
                                      of_cell(step[first], step[second]));
            };
            const Vector3<W> at{pick(kHighA, lattice().across, cells[0].a, cells[1].a),
                                pick(kHighB, lattice().across, cells[0].b, cells[1].b),
                                pick(kHighC, lattice().along, cells[0].c, cells[1].c)};
            const W q = Dot(at, at),
                    limit = of_cell(lattice().limit[cells[0].level], lattice().limit[cells[1].level]);
            const W s =
                hn::Mul(hn::Set(d, parent_radius_),
                        hn::IfThenElse(hn::Gt(q, hn::Set(d, 1.0f)), hn::Div(limit, hn::Sqrt(q)), limit));
            const W radius =
                of_cell(kRadius[cells[0].level] * parent_radius_, kRadius[cells[1].level] * parent_radius_);
            cover(cells, lane, {hn::Mul(at.x, s), hn::Mul(at.y, s), hn::Mul(at.z, s)}, radius);
        }
    }

    // For each centre and each kFlatness the largest (u - cu)^2 + (v - cv)^2 + ((w - cw) / rho)^2, the square
    // of the radius across that covers all points; of those that the level's radius covers, the cheapest. All
    // four at once: the thinner two first, the others only where these fail, is no faster.
    void cover(const std::array<Cell, 2>& cells, size_t lane, const Vector3<W>& centre, W radius) {
        const Wide d;
        // No ball of this radius about a centre that is too far from a side of the points' box holds them: so
        // it is about most centres that anywhere() tries.
        const auto reaches = [&](W at, int k) HWY_ATTR {
            return hn::And(hn::Le(hn::Sub(hn::Set(d, high_[k]), at), radius),
                           hn::Le(hn::Sub(at, hn::Set(d, low_[k])), radius));
        };
        if (hn::AllFalse(d,
                         hn::And(reaches(centre.x, 0), hn::And(reaches(centre.y, 1), reaches(centre.z, 2)))))
            return;
        const W allowed = hn::Mul(hn::Mul(radius, radius), hn::Set(d, 1.0f / (kRoundUp * kRoundUp)));
        W most[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        const W weight0 = hn::Set(d, 1.0f / (kFlatness[0] * kFlatness[0])),
                weight1 = hn::Set(d, 1.0f / (kFlatness[1] * kFlatness[1])),
                weight2 = hn::Set(d, 1.0f / (kFlatness[2] * kFlatness[2]));
        for (size_t i = 0; i < points_; ++i) {
            // Most cells of larger nodes fail, and most of these within a few points.
            if (i % 16 == 15 && hn::AllTrue(d, hn::Gt(most[3], allowed))) return;
            const W du = hn::Sub(hn::Set(d, u_[i * kLanes]), centre.x),
                    dv = hn::Sub(hn::Set(d, v_[i * kLanes]), centre.y),
                    dw = hn::Sub(hn::Set(d, w_[i * kLanes]), centre.z);
            const W across = hn::Add(hn::Mul(du, du), hn::Mul(dv, dv)), along = hn::Mul(dw, dw);
            most[0] = hn::Max(most[0], hn::Add(across, hn::Mul(along, weight0)));
            most[1] = hn::Max(most[1], hn::Add(across, hn::Mul(along, weight1)));
            most[2] = hn::Max(most[2], hn::Add(across, hn::Mul(along, weight2)));
            most[3] = hn::Max(most[3], hn::Add(across, along));
        }
        W cost = hn::Inf(d), shape = hn::Zero(d);
        const W centring = hn::Div(hn::Set(d, 1e-3f), allowed);  // among equals, the best centred
        for (int rho = 3; rho >= 0; --rho) {
            const W weighted = hn::Mul(hn::Mul(radius, hn::Set(d, 1.0f + kThinWeight * kFlatness[rho])),
                                       hn::Add(hn::Set(d, 1.0f), hn::Mul(most[rho], centring)));
            const auto holds = hn::Le(most[rho], allowed);
            cost = hn::IfThenElse(holds, weighted, cost),
            shape = hn::IfThenElse(holds, hn::Set(d, float(rho)), shape);
        }
        const float least = hn::GetLane(hn::MinOfLanes(d, cost));
        if (!(least < best_.cost)) return;
        const auto in_vector = size_t(hn::FindKnownFirstTrue(d, hn::Eq(cost, hn::Set(d, least))));
        const int k = int(lane + in_vector);
        const Cell& cell = cells[size_t(k / 8)];
        const int across = cell.a + (k & 1) + kAcrossSteps * (cell.b + (k >> 1 & 1));
        best_ = {uint32_t(cell.level | across << 4 | (cell.c + (k >> 2 & 1)) << 11),
                 uint32_t(hn::ExtractLane(shape, in_vector)), least};
    }

    static const Lattice& lattice() {
        static const Lattice lattice;
        return lattice;
    }

    const float *u_, *v_, *w_;  // kLanes apart
    const size_t points_;
    const glm::vec3 low_, high_;  // of the points' box
    const glm::vec3 ideal_;
    const float smallest_, parent_radius_;
    Choice best_;
    alignas(64) int32_t a_[kRadiusLevels], b_[kRadiusLevels], c_[kRadiusLevels];
};

void FitGroup(GroupContent& content, const Node& parent, GroupFit& fit) {
    const D d;
    const DU du;
    const Frame frame = frame_about(parent.normal);
    FitState state{};
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
        alignas(32) Lanes<float> wanted[3];
        for (size_t k = 0; k < kLanes; ++k)
            for (int axis = 0; axis < 3; ++axis)
                wanted[axis][k] = k < content.count ? content.normal[k][axis] : float(axis == 2);
        EncodeNormals(Load3(wanted, lane), frame, parent.cone, lane, state);
        TurnPoints(content, parent.radius, lane, state);
    }
    for (size_t k = 0; k < content.count; ++k) {
        fit.normal[k] = {state.normal[0][k], state.normal[1][k], state.normal[2][k]};
        uint32_t cone = 3;
        if (content.face_normals && content.face_begin[k] < content.face_end[k])
            cone = encode_cone(
                LeastDot(*content.face_normals, content.face_begin[k], content.face_end[k], fit.normal[k]),
                parent.cone);
        Search search(content, state, k, parent.radius);
        Choice best = search.nearest();
        const float largest = content.is_leaf[k] ? kMaxLeafInflation : kMaxInnerInflation;
        const auto is_full = [&] { return (best.place & 15u) == kRadiusLevels - 1u; };
        if (content.is_leaf[k] && is_full()) best = search.anywhere();
        state.place[k] = best.place, state.radius_level[k] = kRadius[best.place & 15u];
        fit.attitude[k] = uint16_t(cone << 3 | state.normal_code[k] << 5);
        fit.place[k] = uint16_t(best.place), fit.shape[k] = uint8_t(best.shape);
        fit.inflation[k] = parent.radius * state.radius_level[k] / state.smallest[k];
        fit.is_between[k] = fit.inflation[k] > largest && !is_full();
    }
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
        const FrameLanes<V> own{Load3(state.t1, lane), Load3(state.t2, lane), Load3(state.normal, lane)};
        const V3 offset =
            DecodeOffset(d, hn::Load(du, &state.place[lane]), hn::Load(d, &state.radius_level[lane]), own,
                         hn::Set(d, parent.radius));
        alignas(32) Lanes<float> x, y, z;
        hn::Store(offset.x, d, &x[lane]), hn::Store(offset.y, d, &y[lane]), hn::Store(offset.z, d, &z[lane]);
        for (size_t k = lane; k < lane + hn::Lanes(d); ++k) fit.offset[k] = {x[k], y[k], z[k]};
    }
}

void ExtentOf(const PointArrays& points, size_t begin, size_t end, const Frame& frame, Extent& extent) {
    const D d;
    const V3 t1 = Set3(d, frame.t1), t2 = Set3(d, frame.t2), n = Set3(d, frame.n);
    Extremes e = NoExtremes();
    const V3 first = Set3(d, points.get(begin));
    for (size_t i = begin; i < end; i += hn::Lanes(d)) {
        const auto valid = hn::FirstN(d, end - i);
        const V3 p{hn::IfThenElse(valid, hn::LoadU(d, &points.x[i]), first.x),
                   hn::IfThenElse(valid, hn::LoadU(d, &points.y[i]), first.y),
                   hn::IfThenElse(valid, hn::LoadU(d, &points.z[i]), first.z)};
        e.take({Dot(t1, p), Dot(t2, p), Dot(n, p)});
    }
    for (int k = 0; k < 5; ++k) {
        extent.low[k] = hn::GetLane(hn::MinOfLanes(d, e.low[k]));
        extent.high[k] = hn::GetLane(hn::MaxOfLanes(d, e.high[k]));
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(FitGroup);
HWY_EXPORT(ExtentOf);

void fit_group(GroupContent& content, const Node& parent, GroupFit& fit) {
    HWY_DYNAMIC_DISPATCH(FitGroup)(content, parent, fit);
}

Node node_of(const GroupFit& fit, size_t k, uint16_t colour, const Node& parent) {
    Node node;
    node.cone = decode_cone(fit.attitude[k] >> 3 & 3, parent.cone);
    node.normal = fit.normal[k];
    node.centre = parent.centre + glm::dvec3(fit.offset[k]);
    node.radius = parent.radius * kRadius[fit.place[k] & 15];
    node.flatness = kFlatness[fit.shape[k] & 3];
    node.colour = colour;
    return node;
}

Extent extent_of(const PointArrays& points, size_t begin, size_t end, const Frame& frame) {
    Extent extent;
    HWY_DYNAMIC_DISPATCH(ExtentOf)(points, begin, end, frame, extent);
    return extent;
}

}  // namespace splat
#endif
