#include "splat/cut.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <span>
#include <vector>

#include "core/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cut.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/decode-inl.h"
#include "splat/triangle_reader.h"

#ifndef QS_SPLAT_CUT_ONCE
#define QS_SPLAT_CUT_ONCE
namespace splat {
namespace {

constexpr int kGroup = 8;               // lanes for a group of up to kMaxFanOut nodes
constexpr int kMaxLanes = 16;           // of a vector
constexpr float kDiameterOfError = 20;  // a flat node may be this much wider than its error allows

// The view in model space.  Positions are relative to `pivot`, a point on the line of sight at depth
// `pivot_depth`, so that what is near in depth is small in float.
struct Sides {
    glm::vec3 plane[4];     // unit normals, inwards
    float plane_offset[4];  // distance of the pivot from them
};
struct CutView {
    glm::dvec3 pivot{0};
    float pivot_depth = 0;
    float focal = 1;
    float unit = 1;  // of the splats that are handed out
    glm::vec3 right{0}, down{0}, forward{0};
    Sides sides;  // of the picture for the top, of the raster below it
    Sides raster_sides;
    float corner_cosine = 1;   // of the angle between the line of sight and a corner of the picture
    float near = 0, far = 0;   // depths between which something is drawn
    float limit_error = 0;     // threshold on e f / z
    float limit_diameter = 0;  // threshold on 2 R f / z
    CutPlan plan;
    float limit_triangle = 0;    // on 2 R f / z of leaves
    float rounding = 0;          // of corners, model units
    bool has_triangles = false;  // some leaves may be handed out as such
    bool by_error = true, cull_backfaces = true, two_sided = false, has_colour = false;
    bool is_profiled = false;  // nothing is drawn: all that is visible is listed as open, with what it needs
    uint32_t colour = 0;       // of all, where there is no channel
};

// A node to be opened.
struct Opening {
    glm::vec3 at;  // centre - pivot
    float radius;
    glm::vec3 normal;
    int16_t cone;
    uint8_t children;
    bool is_inside;  // wholly inside the four sides, those of the picture for the top and of the raster below
    bool may_hide = true;  // part of it may be hidden
    uint16_t level = 0;    // of the tree; 0 is the root
    uint32_t slot;   // of its first child, in `block`
    uint64_t block;
};

// Sibling groups of one block, a lane a node: what they and their parents are, and what became of them.
// Groups are short and vectors long, so that as many as fit are worked on together.
struct Chunk {
    static constexpr int kNodes = 128;
    static constexpr int kLanes = kNodes + kMaxLanes;  // the last vector may reach beyond the nodes
    static constexpr uint32_t kChildrenMissing = 16, kParentInside = 32, kParentMayHide = 64;

    int count = 0;
    alignas(64) std::array<uint32_t, kLanes> code;   // attitude, and place in the high half
    alignas(64) std::array<uint32_t, kLanes> shape;  // and flags
    alignas(64) std::array<uint32_t, kLanes> slot, colour;
    alignas(64) std::array<float, kLanes> parent_at[3], parent_normal[3], parent_radius;
    alignas(64) std::array<int32_t, kLanes> parent_cone;
    std::array<uint8_t, kNodes>
        missing{};  // by group: bits of the nodes whose children (or triangles) are not there

    // Leaves that are to be drawn as triangles.
    uint32_t triangle_count = 0;
    alignas(64) std::array<uint32_t, kLanes> triangles;

    // Of the nodes that are to be opened, which the first `open_count` of `open` name.
    uint32_t open_count = 0;
    alignas(64) std::array<uint32_t, kLanes> open, inside;
    alignas(64) std::array<float, kLanes> at[3], offset[3], normal[3], radius;
    alignas(64) std::array<int32_t, kLanes> cone;
    // Where the view is profiled: the smallest threshold at which the node is drawn, and its diameter,
    // pixels.
    alignas(64) std::array<float, kLanes> needed, size;
};

// kErrorOfRadius, row by row.
constexpr auto kErrorByFlatness = [] {
    struct { float of[32]; } all{};
    for (size_t k = 0; k < 32; ++k) all.of[k] = kErrorOfRadius[k / 8][k % 8];
    return all;
}();
// A table that fills a vector of any length.
template <size_t N>
constexpr auto repeated(const float (&table)[N]) {
    std::array<float, N < kMaxLanes ? kMaxLanes : N> all{};
    for (size_t i = 0; i < all.size(); ++i) all[i] = table[i % N];
    return all;
}
alignas(64) constexpr auto kRadiusTable = repeated(kRadius), kFlatnessTable = repeated(kFlatness),
                           kConeTanTable = repeated(kConeTan),
                           kConeCosTable = repeated(kConeCos), kConeSinTable = repeated(kConeSin);
alignas(64) constexpr auto kErrorTable = repeated(kErrorByFlatness.of);

// hn::Iota() writes its lanes one by one and reads them back as a vector, which waits for all of them.
alignas(64) constexpr auto kLaneNumbers = [] {
    std::array<uint32_t, kMaxLanes> all{};
    for (uint32_t i = 0; i < kMaxLanes; ++i) all[i] = i;
    return all;
}();

}  // namespace
}  // namespace splat
#endif  // QS_SPLAT_CUT_ONCE

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kMaxLanes>;
using DU = hn::Rebind<uint32_t, D>;
using DI = hn::Rebind<int32_t, D>;
using V = hn::Vec<D>;
using U = hn::Vec<DU>;
using I = hn::Vec<DI>;
using M = hn::Mask<D>;

using V3 = Vector3<V>;

HWY_INLINE V3 Load3(D d, const std::array<float, Chunk::kLanes> (&from)[3], size_t i) {
    return {hn::Load(d, &from[0][i]), hn::Load(d, &from[1][i]), hn::Load(d, &from[2][i])};
}
HWY_INLINE void Store3(V3 v, D d, std::array<float, Chunk::kLanes> (&to)[3], size_t i) {
    hn::Store(v.x, d, &to[0][i]), hn::Store(v.y, d, &to[1][i]), hn::Store(v.z, d, &to[2][i]);
}

HWY_INLINE U Field(U v, int shift, uint32_t mask) {
    return hn::And(hn::ShiftRightSame(v, shift), hn::Set(DU(), mask));
}

// table[index], of a repeated() table of N.
template <size_t N, class Table>
HWY_INLINE V LookUp(D d, const Table& table, I index) {
    const DI di;
    const size_t lanes = hn::Lanes(d);
    const auto within = hn::IndicesFromVec(d, hn::And(index, hn::Set(di, int32_t(lanes - 1))));
    V found = hn::TableLookupLanes(hn::Load(d, table.data()), within);
    for (size_t first = lanes; first < N; first += lanes) {
        const M beyond = hn::RebindMask(d, hn::Gt(index, hn::Set(di, int32_t(first) - 1)));
        found =
            hn::IfThenElse(beyond, hn::TableLookupLanes(hn::Load(d, table.data() + first), within), found);
    }
    return found;
}

// Puts the groups of `parents`, which lie in `block`, into the chunk.
HWY_INLINE void TakeGroups(std::span<const Opening> parents, const BlockView& block, Chunk& chunk) {
    const hn::CappedTag<float, kGroup> d;
    const hn::RebindToUnsigned<decltype(d)> du;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<uint16_t, decltype(d)> d16;
    chunk.count = 0;
    for (size_t g = 0; g < parents.size(); ++g) {
        const Opening& parent = parents[g];
        const ShapesFrom shapes = block.shapes_from(parent.slot);
        const uint32_t of_parent =
            (parent.is_inside ? Chunk::kParentInside : 0u) | (parent.may_hide ? Chunk::kParentMayHide : 0u);
        for (uint32_t k = 0; k < parent.children; k += uint32_t(hn::Lanes(d))) {
            const auto to = size_t(chunk.count) + k;
            const auto lane = hn::Add(hn::Load(du, kLaneNumbers.data()), hn::Set(du, k));
            // Reads up to 14 bytes too much, which is within the block: the shapes stand last.
            const auto attitude = hn::PromoteTo(du, hn::LoadU(d16, block.attitude() + parent.slot + k));
            const auto place = hn::PromoteTo(du, hn::LoadU(d16, block.place() + parent.slot + k));
            hn::StoreU(hn::Or(attitude, hn::ShiftLeft<16>(place)), du, &chunk.code[to]);
            const auto shape = hn::And(
                hn::Shr(hn::Set(du, shapes.bits), hn::ShiftLeft<2>(hn::Add(lane, hn::Set(du, shapes.first)))),
                hn::Set(du, 15u));
            const auto missing = hn::And(hn::Shr(hn::Set(du, chunk.missing[g]), lane), hn::Set(du, 1u));
            const auto flags =
                hn::Or(hn::Mul(missing, hn::Set(du, Chunk::kChildrenMissing)), hn::Set(du, of_parent));
            hn::StoreU(hn::Or(shape, flags), du, &chunk.shape[to]);
            hn::StoreU(hn::Add(hn::Set(du, parent.slot), lane), du, &chunk.slot[to]);
            if (block.colour())
                hn::StoreU(hn::PromoteTo(du, hn::LoadU(d16, block.colour() + parent.slot + k)), du,
                           &chunk.colour[to]);
            for (int axis = 0; axis < 3; ++axis) {
                hn::StoreU(hn::Set(d, parent.at[axis]), d, &chunk.parent_at[axis][to]);
                hn::StoreU(hn::Set(d, parent.normal[axis]), d, &chunk.parent_normal[axis][to]);
            }
            hn::StoreU(hn::Set(d, parent.radius), d, &chunk.parent_radius[to]);
            hn::StoreU(hn::Set(di, parent.cone), di, &chunk.parent_cone[to]);
        }
        chunk.count += parent.children;
    }
}

// decode_colour() of node.h, as in SplatBatch.
HWY_INLINE U DecodeColour(U v) {
    const auto widen = [](U high, int up, int down) HWY_ATTR {
        return hn::Or(hn::ShiftLeftSame(high, up), hn::ShiftRightSame(high, down));
    };
    const U r = widen(Field(v, 11, 31), 3, 2), g = widen(Field(v, 5, 63), 2, 4),
            b = widen(Field(v, 0, 31), 3, 2);
    return hn::Or(r, hn::Or(hn::ShiftLeft<8>(g), hn::ShiftLeft<16>(b)));
}

// Decodes the groups of `parents`, culls them, lists in `chunk` what is to be opened, and appends what is to
// be drawn to `batch`, which has room for Chunk::kLanes more.
void CutGroups(std::span<const Opening> parents, const BlockView& block, const CutView& view, Chunk& chunk,
               geom::SplatBatch& batch, CutCounts& counts) {
    const D d;
    const DU du;
    const DI di;
    TakeGroups(parents, block, chunk);
    chunk.open_count = chunk.triangle_count = 0;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const M no_lane = hn::Lt(zero, zero);
    V error_px = zero;  // of what is drawn
    for (int first = 0; first < chunk.count; first += int(hn::Lanes(d))) {
        const auto i = size_t(first);
        const M valid = hn::FirstN(d, size_t(chunk.count - first));
        const U code = hn::Load(du, &chunk.code[i]), shape = hn::Load(du, &chunk.shape[i]);
        const U children = Field(code, 0, 7), place = hn::ShiftRight<16>(code);
        const I parent_cone = hn::Load(di, &chunk.parent_cone[i]);
        const V parent_radius = hn::Load(d, &chunk.parent_radius[i]);
        const V3 parent_at = Load3(d, chunk.parent_at, i);
        const M parent_inside = hn::RebindMask(d, hn::TestBit(shape, hn::Set(du, Chunk::kParentInside)));

        // decode_cone()
        const I cone_code = hn::BitCast(di, Field(code, 3, 3));
        const I next = hn::Sub(hn::Add(hn::Max(parent_cone, hn::Zero(di)), hn::Set(di, 2)), cone_code);
        const auto no_cone = hn::Eq(cone_code, hn::Set(di, 3));
        const I cone = hn::IfThenElse(no_cone, hn::Set(di, -1), hn::Min(next, hn::Set(di, kConeCount - 1)));

        const V level = LookUp<kRadiusLevels>(d, kRadiusTable, hn::BitCast(di, Field(place, 0, 15)));
        const auto any_direction = hn::RebindMask(d, hn::Lt(parent_cone, hn::Zero(di)));
        const V cone_tan = LookUp<kConeCount>(d, kConeTanTable, hn::Max(parent_cone, hn::Zero(di)));
        const V3 n = DecodeNormal(d, Field(code, 5, 1023), FrameAbout(d, Load3(d, chunk.parent_normal, i)), cone_tan, any_direction);
        const V3 offset = DecodeOffset(d, place, level, FrameAbout(d, n), parent_radius);
        const V3 at{hn::Add(parent_at.x, offset.x), hn::Add(parent_at.y, offset.y), hn::Add(parent_at.z, offset.z)};
        const V radius = hn::Mul(parent_radius, level);
        const V bound = hn::Mul(radius, hn::Set(d, 1.0f + kSlack));

        const V3 forward = Set3(d, view.forward);
        const V ahead = Dot(forward, at);
        const V z = hn::Add(ahead, hn::Set(d, view.pivot_depth));
        M outside = hn::Or(hn::Lt(hn::Add(z, bound), hn::Set(d, view.near)),
                           hn::Gt(hn::Sub(z, bound), hn::Set(d, view.far)));
        M inside = hn::Gt(z, bound);
        if (!hn::AllTrue(d, hn::Or(parent_inside, hn::Not(valid)))) {
            M beyond = no_lane;
            for (int k = 0; k < 4; ++k) {
                const V distance =
                    hn::Add(Dot(Set3(d, view.sides.plane[k]), at), hn::Set(d, view.sides.plane_offset[k]));
                beyond = hn::Or(beyond, hn::Lt(distance, hn::Neg(bound)));
                inside = hn::And(inside, hn::Gt(distance, bound));
            }
            outside = hn::Or(outside, hn::AndNot(parent_inside, beyond));
        }
        inside = hn::Or(inside, parent_inside);
        // All normals within the cone face away from the eye, seen from anywhere in the sphere.
        const V depth = hn::Set(d, view.pivot_depth);
        const V along = hn::Add(Dot(n, at), hn::Mul(depth, Dot(n, forward)));  // n . (centre - eye)
        const V square = hn::Max(zero, hn::Add(Dot(at, at), hn::Mul(depth, hn::Add(hn::Add(ahead, ahead), depth))));
        const V tangent = hn::Sqrt(hn::Max(zero, hn::Sub(square, hn::Mul(bound, bound))));
        // A half-angle of 180 degrees never faces away.
        const I cone_at = hn::Max(cone, hn::Zero(di));
        const M culls = hn::RebindMask(d, hn::Gt(cone, hn::Set(di, view.cull_backfaces ? -1 : kConeCount)));
        const V cosine = hn::IfThenElse(culls, LookUp<kConeCount>(d, kConeCosTable, cone_at), hn::Neg(one));
        const V sine = hn::IfThenElseZero(culls, LookUp<kConeCount>(d, kConeSinTable, cone_at));
        const M away = hn::And(hn::Gt(along, hn::Add(hn::Mul(bound, cosine), hn::Mul(tangent, sine))),
                               hn::Gt(hn::Mul(tangent, cosine), hn::Mul(bound, sine)));
        outside = hn::And(valid, outside);
        const M backface = hn::And(valid, hn::AndNot(outside, away));
        const M visible = hn::AndNot(hn::Or(outside, backface), valid);

        const V flat = LookUp<4>(d, kFlatnessTable, hn::BitCast(di, Field(shape, 0, 3)));
        const V facing = Dot(n, forward);
        // Nearest depth of what can be seen of the ellipsoid: where it reaches to the eye's plane beside the view,
        // the picture's corners are still this far ahead.
        const V reach = hn::Mul(radius, hn::Sqrt(hn::Max(zero, hn::Sub(one, hn::Mul(hn::Sub(one, hn::Mul(flat, flat)), hn::Mul(facing, facing))))));
        const V length = hn::Sqrt(square);
        const V nearest = hn::Max(
            hn::Set(d, view.near),
            hn::Max(hn::Sub(z, reach), hn::Mul(hn::Sub(length, radius), hn::Set(d, view.corner_cosine))));
        const V focal = hn::Set(d, view.focal);
        // What is drawn is the plane through the centre conjugate to the line of sight: the disc, seen from the
        // front, and up to the half thickness off it where it is seen on edge.
        const V most = hn::Div(hn::Max(zero, hn::Sub(hn::Abs(along), radius)), hn::Add(length, radius));
        const V cos2 = hn::Mul(most, most), lean = hn::Mul(hn::Mul(flat, flat), hn::Sub(one, cos2));
        const V off_disc = hn::Mul(flat, hn::Sqrt(hn::Div(lean, hn::Add(cos2, lean))));
        const U error_at = hn::Or(hn::ShiftLeft<3>(Field(shape, 0, 3)), hn::Or(hn::ShiftLeft<2>(Field(code, 15, 1)), Field(shape, 2, 3)));
        const V error_of_radius = LookUp<32>(d, kErrorTable, hn::BitCast(di, error_at));
        const V error = hn::Mul(hn::Mul(radius, hn::Add(error_of_radius, off_disc)), focal);
        const V diameter = hn::Mul(hn::Add(radius, radius), focal);
        M small = hn::Le(diameter, hn::Mul(hn::Set(d, view.limit_diameter), nearest));
        if (view.by_error) small = hn::And(small, hn::Le(error, hn::Mul(hn::Set(d, view.limit_error), nearest)));
        const auto leaf = hn::Eq(children, hn::Zero(du));
        const auto missing = hn::TestBit(shape, hn::Set(du, Chunk::kChildrenMissing));
        const M ends = hn::RebindMask(d, hn::Or(leaf, missing));
        M drawn = view.is_profiled ? no_lane : hn::And(visible, hn::Or(ends, small));
        const M open = hn::AndNot(drawn, visible);

        counts.frustum_culled += hn::CountTrue(d, outside);
        counts.backface_culled += hn::CountTrue(d, backface);
        const M is_parent = hn::Not(hn::RebindMask(d, leaf));
        if (!hn::AllFalse(d, open)) {
            const U lane = hn::Add(hn::Load(du, kLaneNumbers.data()), hn::Set(du, uint32_t(first)));
            hn::StoreU(hn::Compress(lane, hn::RebindMask(du, open)), du, &chunk.open[chunk.open_count]);
            chunk.open_count += uint32_t(hn::CountTrue(d, open));
            Store3(at, d, chunk.at, i), Store3(offset, d, chunk.offset, i), Store3(n, d, chunk.normal, i);
            hn::Store(radius, d, &chunk.radius[i]), hn::Store(cone, di, &chunk.cone[i]);
            hn::Store(hn::VecFromMask(du, hn::RebindMask(du, inside)), du, &chunk.inside[i]);
            if (view.is_profiled) {
                const V of_diameter = hn::Mul(diameter, hn::Set(d, 1 / kDiameterOfError));
                const V wanted = view.by_error ? hn::Max(error, of_diameter) : diameter;
                const auto projected = [&](V length_px) HWY_ATTR {
                    return hn::IfThenElse(hn::Gt(nearest, zero), hn::Div(length_px, nearest), hn::Inf(d));
                };
                hn::Store(projected(wanted), d, &chunk.needed[i]),
                    hn::Store(projected(diameter), d, &chunk.size[i]);
            }
        }

        if (hn::AllFalse(d, drawn)) continue;
        if (view.has_triangles) {
            const M wanted = hn::And(hn::And(drawn, hn::RebindMask(d, leaf)),
                                     hn::Ge(diameter, hn::Mul(hn::Set(d, view.limit_triangle), nearest)));
            const M lacks = hn::And(wanted, hn::RebindMask(d, missing)), found = hn::AndNot(lacks, wanted);
            counts.groups_missing += hn::CountTrue(d, lacks);
            if (!hn::AllFalse(d, found)) {
                const U lane = hn::Iota(du, uint32_t(first));
                hn::StoreU(hn::Compress(lane, hn::RebindMask(du, found)), du,
                           &chunk.triangles[chunk.triangle_count]);
                chunk.triangle_count += uint32_t(hn::CountTrue(d, found));
                const V rounding = hn::Set(d, view.rounding * view.focal);
                const V off = hn::IfThenElse(hn::Gt(nearest, zero), hn::Div(rounding, nearest), hn::Inf(d));
                error_px = hn::Max(error_px, hn::IfThenElseZero(found, off));
                drawn = hn::AndNot(found, drawn);
                if (hn::AllFalse(d, drawn)) continue;
            }
        }
        counts.groups_missing += hn::CountTrue(d, hn::And(is_parent, hn::AndNot(small, drawn)));
        const V safe = hn::IfThenElse(hn::Gt(nearest, zero), hn::Div(error, nearest), hn::Inf(d));
        error_px = hn::Max(error_px, hn::IfThenElseZero(drawn, safe));
        const int to = batch.count;
        // What stands for surface on several sides is shown from the side it is seen from.
        const M many_sided =
            view.two_sided ? hn::Eq(zero, zero) : hn::And(hn::RebindMask(d, no_cone), is_parent);
        const M turned = hn::And(hn::Gt(along, zero), many_sided);
        const V sign = hn::IfThenElse(turned, hn::Neg(one), one);
        V3 shown{hn::Mul(n.x, sign), hn::Mul(n.y, sign), hn::Mul(n.z, sign)};
        if (view.two_sided) {
            // A ball without a cone is a point without a normal, and faces the eye.
            const M is_ball =
                hn::And(hn::Eq(flat, one), hn::RebindMask(d, hn::And(leaf, hn::RebindMask(du, no_cone))));
            const V inverse = hn::Div(hn::Neg(one), hn::Max(length, hn::Set(d, 1e-30f)));
            const auto to_eye = [&](V from_pivot, V axis) HWY_ATTR {
                return hn::Mul(hn::Add(from_pivot, hn::Mul(depth, axis)), inverse);
            };
            shown = {hn::IfThenElse(is_ball, to_eye(at.x, forward.x), shown.x),
                     hn::IfThenElse(is_ball, to_eye(at.y, forward.y), shown.y),
                     hn::IfThenElse(is_ball, to_eye(at.z, forward.z), shown.z)};
        }
        // Compressed in the register, then stored whole: compressing stores are slow on some processors.
        const auto put = [&](V value, float* channel) { hn::StoreU(hn::Compress(value, drawn), d, channel + to); };
        const V unit = hn::Set(d, view.unit);
        put(hn::Mul(Dot(Set3(d, view.right), at), unit), batch.x);
        put(hn::Mul(Dot(Set3(d, view.down), at), unit), batch.y);
        put(hn::Mul(z, unit), batch.z);
        put(Dot(Set3(d, view.right), shown), batch.nx), put(Dot(Set3(d, view.down), shown), batch.ny), put(Dot(forward, shown), batch.nz);
        put(hn::Mul(radius, unit), batch.radius), put(flat, batch.flatness);
        if (view.has_colour)
            hn::StoreU(hn::Compress(DecodeColour(hn::Load(du, &chunk.colour[i])), hn::RebindMask(du, drawn)),
                       du, batch.colour + to);
        else
            hn::StoreU(hn::Set(du, view.colour), du, batch.colour + to);
        batch.count += int(hn::CountTrue(d, drawn));
        counts.splats += hn::CountTrue(d, drawn);
        counts.closed += hn::CountTrue(d, hn::AndNot(ends, drawn));
    }
    counts.nodes_visited += uint64_t(chunk.count);
    counts.error_bound_px = std::max(counts.error_bound_px, double(hn::GetLane(hn::MaxOfLanes(d, error_px))));
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(CutGroups);

namespace {

// The top ends where this many nodes wait to be opened; twice as many cut the dragon into 1216 tasks, whose
// short levels fill vectors badly and took 10 % more of a frame.
constexpr size_t kTasks = 128;
// Levels are outlined until half of their nodes are smaller than this.  The first outline tells whether there
// is much to hide, for 1 % of the dragon's frame (100 px: 2 %); the second hides two to five times as much.
// 40 px alone would hide a twentieth more, and cost frames with nothing to hide 8 %.
constexpr float kOutlinePx[] = {140, 40};
constexpr size_t kOutlines = std::size(kOutlinePx);
constexpr uint32_t kLineNodes = 32;   // nodes in a cache line of a channel
constexpr size_t kCachedBlocks = 64;  // a thread's opened blocks, by number modulo this

constexpr size_t kCachedTriangles = 16;  // blocks whose triangles a thread keeps open

// The corners of a run in view space, each decoded when it is first asked for.
struct DecodedRun {
    uint64_t block = ~uint64_t(0);  // of nodes
    uint32_t run = 0;
    std::vector<uint8_t> is_decoded;
    std::vector<glm::vec3> at, normal;
};

// What a thread keeps between tasks and frames.
struct Walker {
    std::array<BlockView, kCachedBlocks> blocks;
    std::array<BlockTriangles, kCachedTriangles> triangles;
    DecodedRun run;
    geom::TriangleBatch triangle_batch;
    std::vector<Opening> level, next;
    Chunk chunk;
    geom::SplatBatch batch;
    std::vector<geom::OcclusionMap::Surface> surfaces;

    BlockView& open_block(const Model& model, uint64_t number) {
        BlockView& view = blocks[number % kCachedBlocks];
        if (!view.is_open() || view.number() != number) view.open(model, number);
        return view;
    }
    const BlockTriangles& open_triangles(const Model& model, const BlockView& block) {
        BlockTriangles& found = triangles[block.number() % kCachedTriangles];
        if (!found.is_open() || found.number() != block.number()) found.open(model, block);
        return found;
    }
};

// Where splats and triangles go.
struct Sinks {
    const Cut::Sink& splats;
    const Cut::TriangleSink& triangles;
};

// The sides of the pyramid through the raster, for a pivot at `depth`.
Sides sides_of(const geom::View& view, double depth) {
    const glm::dvec2 principal = view.principal_in_raster();
    const double left = principal.x / view.focal_px, right = (view.width - principal.x) / view.focal_px;
    const double above = principal.y / view.focal_px, below = (view.height - principal.y) / view.focal_px;
    const glm::dvec3 normals[4] = {view.right + left * view.forward, right * view.forward - view.right,
                                   view.down + above * view.forward, below * view.forward - view.down};
    Sides sides;
    for (int k = 0; k < 4; ++k) {
        const glm::dvec3 n = glm::normalize(normals[k]);
        sides.plane[k] = glm::vec3(n);
        sides.plane_offset[k] = float(depth * glm::dot(n, view.forward));
    }
    return sides;
}

// What outlining came to: the nodes that wait to be opened, and the splats of the levels above them.
struct Outline {
    struct Splat {
        float x, y, z, radius, nx, ny, nz, flatness;
        uint32_t colour;
    };
    std::vector<Opening> level;
    std::vector<Splat> splats;
    std::vector<geom::TriangleBatch> triangles;
    std::vector<geom::OcclusionMap::Sight> sights;  // of the level, once it is sifted

    void keep(const geom::SplatBatch& b) {
        for (int i = 0; i < b.count; ++i)
            splats.push_back(
                {b.x[i], b.y[i], b.z[i], b.radius[i], b.nx[i], b.ny[i], b.nz[i], b.flatness[i], b.colour[i]});
    }
    void hand_out(geom::SplatBatch& batch, const Sinks& sinks) const {
        for (const geom::TriangleBatch& kept : triangles) sinks.triangles(kept);
        for (const Splat& s : splats) {
            if (batch.count == geom::SplatBatch::kCapacity) sinks.splats(batch), batch.count = 0;
            const int i = batch.count++;
            batch.x[i] = s.x, batch.y[i] = s.y, batch.z[i] = s.z, batch.radius[i] = s.radius;
            batch.nx[i] = s.nx, batch.ny[i] = s.ny, batch.nz[i] = s.nz, batch.flatness[i] = s.flatness;
            batch.colour[i] = s.colour;
        }
    }
};

// The outlines of a task in this frame, each of what the one before left.
struct TaskOutlines {
    std::array<Outline, kOutlines> of;
    int count = 0;

    Outline& last() { return of[size_t(count - 1)]; }
};

CutPlan make_plan(const Header& h, const CutOptions& options, bool is_cut_open) {
    CutPlan plan;
    if (!options.cull_backfaces)
        plan.backfaces = BackfaceTest::not_wanted;
    else if (h.flags & kOpenSurface)
        plan.backfaces = BackfaceTest::open_surface;
    else if (is_cut_open)
        plan.backfaces = BackfaceTest::cut_open_by_near;
    if (h.has_colour())
        plan.colour = ColourFrom::channel;
    else if (h.flags & kConstantColour)
        plan.colour = ColourFrom::header;
    return plan;
}

CutView make_cut_view(const Model& model, const geom::View& view, const CutOptions& options) {
    const Header& h = model.header();
    CutView v;
    const glm::dvec3 eye = (view.eye - h.origin) / h.scale;
    // The depth of the model's middle, as far as the eye is outside.
    const double depth = std::max(0.0, -glm::dot(eye, view.forward) - 1.0);
    v.pivot = eye + depth * view.forward;
    v.pivot_depth = float(depth);
    v.focal = float(view.focal_px);
    v.right = glm::vec3(view.right), v.down = glm::vec3(view.down), v.forward = glm::vec3(view.forward);
    v.sides = sides_of(part_of(view, 0, 0, view.picture_width(), view.picture_height()), depth);
    v.raster_sides = sides_of(view, depth);
    const glm::dvec2 principal = view.principal();
    const double far_x = std::max(principal.x, view.picture_width() - principal.x) / view.focal_px;
    const double far_y = std::max(principal.y, view.picture_height() - principal.y) / view.focal_px;
    v.corner_cosine = float(1 / std::sqrt(1 + far_x * far_x + far_y * far_y));
    constexpr double kFarthest = std::numeric_limits<float>::max();
    v.near = float(std::min(view.near.value_or(0) / h.scale, kFarthest));
    v.far = float(std::min(view.far.value_or(kFarthest) / h.scale, kFarthest));
    v.by_error = options.by == CutBy::error;
    v.limit_error = float(options.threshold_px);
    v.limit_diameter = float(v.by_error ? options.threshold_px * double(kDiameterOfError) : options.threshold_px);
    v.has_triangles = h.has_triangles() && hands_out_triangles(options);
    v.limit_triangle = float(options.triangle_px);
    v.rounding = float(std::ldexp(0.87, -int(h.lattice_bits)));  // sqrt(3) / 2 steps
    // What near cuts open shows its inside.
    const bool is_cut_open = view.near && *view.near / h.scale > -glm::dot(eye, view.forward) - 1.0;
    v.plan = make_plan(h, options, is_cut_open);
    v.cull_backfaces = v.plan.backfaces == BackfaceTest::made;
    v.two_sided = h.flags & kCloud;
    v.has_colour = v.plan.colour == ColourFrom::channel;
    v.colour = v.plan.colour == ColourFrom::header
                   ? uint32_t(h.colour[0]) | uint32_t(h.colour[1]) << 8 | uint32_t(h.colour[2]) << 16
                   : 0x00e6e6e6;
    return v;
}

}  // namespace

void CutCounts::add(const CutCounts& o) {
    nodes_visited += o.nodes_visited, frustum_culled += o.frustum_culled, backface_culled += o.backface_culled;
    occlusion_culled += o.occlusion_culled, triangles += o.triangles;
    splats += o.splats, closed += o.closed, blocks_touched += o.blocks_touched,
        groups_missing += o.groups_missing;
    side_tests += o.side_tests, side_test_level = std::max(side_test_level, o.side_test_level);
    error_bound_px = std::max(error_bound_px, o.error_bound_px);
}

struct Cut::State {
    using Sight = geom::OcclusionMap::Sight;

    explicit State(const Model& m) : model(m), touched(std::make_unique<std::atomic<uint8_t>[]>(m.blocks_present())) {}

    const Model& model;
    const double step = std::ldexp(1.0, -int(model.header().lattice_bits));
    // What the blocks that are there can hold, whatever the header says: more visits mean shared groups.
    const uint64_t most_nodes =
        std::min(model.header().node_count, model.node_blocks_present() * model.layout().capacity);
    CutView view;
    std::vector<Opening> tasks;
    geom::SplatBatch top_batch;
    std::vector<geom::SplatBatch> top_batches;  // splats of the top, drawn with task 0
    std::vector<geom::TriangleBatch> top_triangles;
    CutCounts top_counts;
    std::mutex mutex;
    CutCounts counts;
    tbb::enumerable_thread_specific<Walker> walkers;
    std::unique_ptr<std::atomic<uint8_t>[]> touched;  // by block: the frame it was last used in
    uint8_t frame = 0;
    std::vector<TaskOutlines> outlines;  // by task

    void add(const CutCounts& c) {
        const std::scoped_lock lock(mutex);
        counts.add(c);
    }

    // Opens nodes whose groups lie in one block: the groups are cut, drawn nodes go to the batch, the others
    // to push(opening, offset).
    template <class Push>
    void open(std::span<const Opening> nodes, Walker& walker, geom::SplatBatch& batch, CutCounts& c,
              geom::OcclusionMap* map, const Push& push) {
        const uint64_t number = nodes[0].block;
        BlockView& block = walker.open_block(model, number);
        // Nearly always touched already, which a load tells for a tenth of an exchange.
        if (touched[number].load(std::memory_order_relaxed) != frame &&
            touched[number].exchange(frame, std::memory_order_relaxed) != frame)
            ++c.blocks_touched;
        check_groups(nodes, block);
        count_side_tests(nodes, c);
        Chunk& chunk = walker.chunk;
        if (!model.is_complete()) mark_missing(nodes, walker, block, chunk);
        HWY_DYNAMIC_DISPATCH(CutGroups)(nodes, block, view, chunk, batch, c);
        if (c.nodes_visited > most_nodes) model.fault(number, "is reached more than once");
        if (chunk.triangle_count > 0) add_triangles(walker, block, c);
        GroupAt asked{~uint64_t{0}, 0};
        for (uint32_t i = 0; i < chunk.open_count; ++i) {
            const size_t k = chunk.open[i];
            const bool is_looked_at = map && chunk.shape[k] & Chunk::kParentMayHide;
            const glm::vec3 at(chunk.at[0][k], chunk.at[1][k], chunk.at[2][k]);
            const Sight sight = is_looked_at ? look(at, chunk.radius[k], *map) : Sight::clear;
            if (sight == Sight::hidden) {
                // A repeated walk leaves out what is not hidden, or was counted before.
                c.occlusion_culled += !map->is_repeated();
                continue;
            }
            const GroupAt group = group_of(block, chunk.slot[k]);
            // Groups follow each other: most lie in lines that were asked for already.
            if (group.block != asked.block || group.slot / kLineNodes != asked.slot / kLineNodes)
                model.prefetch(asked = group);
            push(opening_of(chunk, k, group, nodes[0].level, !map || sight == Sight::partly),
                 glm::dvec3(chunk.offset[0][k], chunk.offset[1][k], chunk.offset[2][k]));
        }
    }

    // From what is relative to the pivot, in the splats' unit.
    glm::vec3 in_view(const glm::vec3& at) const {
        return view.unit * glm::vec3(glm::dot(view.right, at), glm::dot(view.down, at),
                                     glm::dot(view.forward, at) + view.pivot_depth);
    }

    Sight look(const glm::vec3& at, float radius, geom::OcclusionMap& map) const {
        return map.look(in_view(at), radius * (1.0f + kSlack) * view.unit);
    }

    static void count_side_tests(std::span<const Opening> nodes, CutCounts& c) {
        for (const Opening& node : nodes) {
            if (node.is_inside) continue;
            c.side_tests += node.children;
            c.side_test_level = std::max(c.side_test_level, node.level + 1u);
        }
    }

    void check_groups(std::span<const Opening> nodes, const BlockView& block) const {
        for (const Opening& node : nodes)
            if (node.slot + node.children > block.node_count())
                model.fault(block.number(), "a sibling group goes beyond its nodes");
    }

    GroupAt group_of(BlockView& block, uint32_t slot) const {
        const GroupAt group = block.group_of(slot);
        if (group.block < block.number() || (group.block == block.number() && group.slot <= slot))
            model.fault(block.number(), "a node's children stand before it");
        return group;
    }

    static Opening opening_of(const Chunk& chunk, size_t k, const GroupAt& group, uint16_t parent_level,
                              bool may_hide) {
        return {{chunk.at[0][k], chunk.at[1][k], chunk.at[2][k]},
                chunk.radius[k],
                {chunk.normal[0][k], chunk.normal[1][k], chunk.normal[2][k]},
                int16_t(chunk.cone[k]),
                uint8_t(chunk.code[k] & 7),
                chunk.inside[k] != 0,
                may_hide,
                uint16_t(parent_level + 1),
                group.slot,
                group.block};
    }

    Opening root_opening(const CutView& v) const {
        const Node root = model.root();
        return {glm::vec3(-v.pivot), 1.0f, root.normal, int16_t(root.cone), uint8_t(root.children), false, true, 0, 0, 0};
    }

    void mark_missing(std::span<const Opening> nodes, Walker& walker, BlockView& block, Chunk& chunk) const {
        const BlockTriangles* triangles = view.has_triangles ? &walker.open_triangles(model, block) : nullptr;
        for (size_t g = 0; g < nodes.size(); ++g) {
            uint32_t bits = 0;
            for (uint32_t k = 0; k < nodes[g].children; ++k) {
                const uint32_t slot = nodes[g].slot + k;
                const bool is_missing =
                    block.children_of(slot) != 0
                        ? !model.has_block(block.group_of(slot).block)
                        : triangles && triangles->find(slot).run == BlockTriangles::Place::kNone;
                bits |= uint32_t(is_missing) << k;
            }
            chunk.missing[g] = uint8_t(bits);
        }
    }

    // Appends the chunk's triangles to the walker's batch, which has room for them.
    void add_triangles(Walker& walker, const BlockView& block, CutCounts& c) {
        const Chunk& chunk = walker.chunk;
        const BlockTriangles& triangles = walker.open_triangles(model, block);
        for (uint32_t i = 0; i < chunk.triangle_count; ++i) {
            const size_t lane = chunk.triangles[i];
            const BlockTriangles::Place at = triangles.find(chunk.slot[lane]);
            if (at.run == BlockTriangles::Place::kNone)
                model.fault(block.number(), "has leaves without triangles");
            const BlockTriangles::PlacedRun& placed = triangles.runs()[at.run];
            DecodedRun& run = walker.run;
            if (run.block != block.number() || run.run != at.run) {
                run.block = block.number(), run.run = at.run;
                run.is_decoded.assign(placed.run.corners(), false);
                run.at.resize(placed.run.corners()), run.normal.resize(placed.run.corners());
                if (touched[placed.block].exchange(frame, std::memory_order_relaxed) != frame)
                    ++c.blocks_touched;
            }
            add_triangle(placed, at.triangle, colour_of(chunk, lane), run, walker.triangle_batch);
        }
        c.triangles += chunk.triangle_count;
    }

    void add_triangle(const BlockTriangles::PlacedRun& placed, uint32_t triangle, uint32_t colour,
                      DecodedRun& decoded, geom::TriangleBatch& batch) const {
        const TriangleRun& run = placed.run;
        const glm::u32vec3 entries = placed.entries[triangle];
        for (int k = 0; k < 3; ++k)
            if (!decoded.is_decoded[entries[k]]) decode_corner(run, entries[k], decoded);
        glm::vec3 flat(0);
        const bool is_smooth = run.is_smooth(triangle);
        if (!is_smooth) {
            const glm::dvec3 a(run.position(entries.x));
            const glm::dvec3 n =
                glm::cross(glm::dvec3(run.position(entries.y)) - a, glm::dvec3(run.position(entries.z)) - a);
            const double length = glm::length(n);
            if (!(length > 0)) return;  // without area there is nothing to show
            flat = turned(glm::vec3(n / length));
        }
        const int to = batch.count++;
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 &at = decoded.at[entries[k]], &n = is_smooth ? decoded.normal[entries[k]] : flat;
            batch.x[k][to] = at.x, batch.y[k][to] = at.y, batch.z[k][to] = at.z;
            batch.nx[k][to] = n.x, batch.ny[k][to] = n.y, batch.nz[k][to] = n.z;
        }
        batch.colour[to] = colour;
    }

    // From its place on the lattice in the same way whatever run it is in, and so to the same bits.
    void decode_corner(const TriangleRun& run, uint32_t entry, DecodedRun& decoded) const {
        const glm::dvec3 at = glm::dvec3(run.position(entry)) * step;
        decoded.at[entry] = in_view(glm::vec3(at - view.pivot));
        if (run.has_normals()) decoded.normal[entry] = turned(decode_corner_normal(run.normal_code(entry)));
        decoded.is_decoded[entry] = true;
    }

    glm::vec3 turned(const glm::vec3& n) const {
        return {glm::dot(view.right, n), glm::dot(view.down, n), glm::dot(view.forward, n)};
    }

    uint32_t colour_of(const Chunk& chunk, size_t lane) const {
        if (!view.has_colour) return view.colour;
        const glm::u8vec3 rgb = decode_colour(uint16_t(chunk.colour[lane]));
        return uint32_t(rgb.r) | uint32_t(rgb.g) << 8 | uint32_t(rgb.b) << 16;
    }

    static bool is_full(const geom::SplatBatch& batch) {
        return batch.count + Chunk::kLanes > geom::SplatBatch::kCapacity;
    }
    static bool is_full(const geom::TriangleBatch& batch) {
        return batch.count + Chunk::kNodes > geom::TriangleBatch::kCapacity;
    }
    template <class Batch, class Taker>
    static void empty(Batch& batch, const Taker& sink) {
        if (batch.count > 0) sink(batch);
        batch.count = 0;
    }

    // As many nodes from the first on as a chunk takes.
    static std::span<const Opening> first_chunk(std::span<const Opening> nodes) {
        size_t n = 0;
        for (int count = 0; n < nodes.size() && nodes[n].block == nodes[0].block; ++n) {
            count += nodes[n].children;
            if (count > Chunk::kNodes) break;
        }
        return nodes.first(n);
    }

    // The levels above the tasks, with centres in double.  They are cut to the whole picture, whatever part
    // of it is drawn, so that the tasks are the same, and with them the order of the splats.
    void walk_top() {
        top_counts = {};
        top_batches.clear();
        top_batch.count = 0;
        top_triangles.clear();
        const auto keep = [&](const geom::TriangleBatch& batch) { top_triangles.push_back(batch); };
        std::vector<std::pair<Opening, glm::dvec3>> level, next;
        level.push_back({root_opening(view), glm::dvec3(0)});
        Walker& walker = begin_walk();
        while (!level.empty() && level.size() < kTasks) {
            next.clear();
            for (const auto& [node, centre] : level) {
                const glm::dvec3 from = centre;
                if (is_full(top_batch)) top_batches.push_back(top_batch), top_batch.count = 0;
                if (is_full(walker.triangle_batch)) empty(walker.triangle_batch, keep);
                open({&node, 1}, walker, top_batch, top_counts, nullptr,
                     [&](Opening child, const glm::dvec3& offset) {
                         const glm::dvec3 c = from + offset;
                         child.at = glm::vec3(c - view.pivot);
                         next.emplace_back(child, c);
                     });
            }
            std::swap(level, next);
        }
        if (top_batch.count > 0) top_batches.push_back(top_batch);
        empty(walker.triangle_batch, keep);
        tasks.clear();
        for (const auto& [node, centre] : level) tasks.push_back(node);
    }

    void narrow_to_raster() {
        view.sides = view.raster_sides;
        for (Opening& task : tasks) task.is_inside = false;
    }

    // The thread's walker, with nothing in its batches, and no run decoded for another view.
    Walker& begin_walk() {
        Walker& walker = walkers.local();
        walker.batch.count = walker.triangle_batch.count = 0;
        walker.run.block = ~uint64_t(0);
        return walker;
    }

    // Cuts the walker's level, and makes the next one its own.
    void walk_level(Walker& walker, const Sinks& sinks, geom::OcclusionMap* map, CutCounts& c) {
        walker.next.clear();
        for (std::span<const Opening> rest = walker.level, nodes; !rest.empty();
             rest = rest.subspan(nodes.size())) {
            nodes = first_chunk(rest);
            if (is_full(walker.batch)) empty(walker.batch, sinks.splats);
            if (is_full(walker.triangle_batch)) empty(walker.triangle_batch, sinks.triangles);
            open(nodes, walker, walker.batch, c, map,
                 [&](const Opening& child, const glm::dvec3&) { walker.next.push_back(child); });
        }
        std::swap(walker.level, walker.next);
    }

    void walk_task(size_t task, const Sinks& sinks, geom::OcclusionMap* map, CutCounts& c) {
        Walker& walker = begin_walk();
        TaskOutlines& made = outlines[task];
        if (made.count == 0) {
            walker.level.assign(1, tasks[task]);
        } else {
            // Later outlines lack what the first one hid.
            if (map && map->is_repeated()) made.count = 1;
            for (int k = 0; k < made.count; ++k) made.of[size_t(k)].hand_out(walker.batch, sinks);
            start_from(made.last(), walker, map, c);
        }
        while (!walker.level.empty()) walk_level(walker, sinks, map, c);
        empty(walker.batch, sinks.splats), empty(walker.triangle_batch, sinks.triangles);
    }

    void start_from(const Outline& outline, Walker& walker, geom::OcclusionMap* map, CutCounts& c) const {
        walker.level.clear();
        for (size_t i = 0; i < outline.level.size(); ++i) {
            const Opening& node = outline.level[i];
            Sight sight = Sight::partly;
            if (map) sight = map->is_repeated() ? look(node.at, node.radius, *map) : outline.sights[i];
            c.occlusion_culled += sight == Sight::hidden && !map->is_repeated();
            if (sight == Sight::hidden) continue;
            walker.level.push_back(node);
            walker.level.back().may_hide = sight == Sight::partly;
        }
    }

    bool is_coarse(const std::vector<Opening>& level, float most_px) const {
        const auto is_wide = [&](const Opening& node) {
            return 2 * node.radius * view.focal >
                   most_px * (glm::dot(view.forward, node.at) + view.pivot_depth);
        };
        return 2 * size_t(std::count_if(level.begin(), level.end(), is_wide)) > level.size();
    }

    void outline(size_t task, geom::OcclusionMap& map, CutCounts& c) {
        Walker& walker = begin_walk();
        TaskOutlines& made = outlines[task];
        if (made.count == 0)
            walker.level.assign(1, tasks[task]);
        else
            start_from(made.last(), walker, &map, c);
        const float most_px = kOutlinePx[made.count++];
        Outline& outline = made.last();
        outline.splats.clear(), outline.triangles.clear();
        const Sink keep = [&](const geom::SplatBatch& batch) { outline.keep(batch); };
        const TriangleSink keep_triangles = [&](const geom::TriangleBatch& batch) {
            outline.triangles.push_back(batch);
        };
        while (is_coarse(walker.level, most_px)) walk_level(walker, {keep, keep_triangles}, nullptr, c);
        empty(walker.batch, keep), empty(walker.triangle_batch, keep_triangles);
        outline.level.assign(walker.level.begin(), walker.level.end());
        show(outline, walker.surfaces, map);
    }

    void show(const Outline& outline, std::vector<geom::OcclusionMap::Surface>& surfaces,
              geom::OcclusionMap& map) const {
        surfaces.clear();
        for (const Opening& node : outline.level) {
            const glm::vec3 centre = in_view(node.at), n = node.normal;
            const glm::vec3 normal(glm::dot(view.right, n), glm::dot(view.down, n),
                                   glm::dot(view.forward, n));
            if (view.cull_backfaces && glm::dot(normal, centre) > 0) continue;
            // A surface that bends by the cone's half-angle is off its disc by about half the sine.
            const float radius = node.radius * view.unit;
            const float bend = node.cone < 0 ? 2.0f : 0.5f * kConeSin[node.cone];
            surfaces.push_back({centre, radius, normal, bend * radius});
        }
        for (const Outline::Splat& s : outline.splats)
            surfaces.push_back({{s.x, s.y, s.z}, s.radius, {s.nx, s.ny, s.nz}, s.radius * s.flatness});
        map.add_surfaces(surfaces);
    }

    // Nodes to be opened in a walk that profiles: at thresholds before `steps` of the profile.
    struct ProfiledLevel {
        std::vector<Opening> nodes;
        std::vector<int> steps;

        void clear() { nodes.clear(), steps.clear(); }
        void keep(size_t from, size_t to) { nodes[to] = nodes[from], steps[to] = steps[from]; }
        void shorten(size_t count) { nodes.resize(count), steps.resize(count); }
    };

    // Opens nodes whose groups lie in one block.  What they hold counts `weight` times.
    void profile_nodes(std::span<const Opening> nodes, const int* steps, double weight, const CutView& v,
                       Walker& walker, CutProfile& profile, ProfiledLevel& next) {
        const uint64_t number = nodes[0].block;
        // Not by whether the block was checked: walks of this kind check some blocks, too.
        const bool is_cold = touched[number].load(std::memory_order_relaxed) == 0;
        BlockView& block = walker.open_block(model, number);
        check_groups(nodes, block);
        Chunk& chunk = walker.chunk;
        chunk.missing.fill(0);
        CutCounts unused;
        HWY_DYNAMIC_DISPATCH(CutGroups)(nodes, block, v, chunk, walker.batch, unused);
        size_t g = 0;
        for (uint32_t i = 0, end = nodes[0].children; i < chunk.open_count; ++i) {
            const size_t k = chunk.open[i];
            while (k >= end) end += nodes[++g].children;
            const bool is_leaf = (chunk.code[k] & 7) == 0;
            const GroupAt group = is_leaf ? GroupAt{} : group_of(block, chunk.slot[k]);
            const bool ends = is_leaf || !model.has_block(group.block);
            const int drawn_from = ends ? 0 : profile.step_of(double(chunk.needed[k]));
            profile.add_splat(drawn_from, steps[g], double(chunk.size[k]), weight);
            if (const int opened = std::min(drawn_from, steps[g]); opened > 0)
                next.nodes.push_back(opening_of(chunk, k, group, nodes[0].level, false)), next.steps.push_back(opened);
        }
        for (size_t n = 0; n < nodes.size(); ++n)
            profile.add_nodes(steps[n], weight * double(nodes[n].children), is_cold);
    }

    CutProfile profile(const CutView& v, const ProfileOptions& options, uint64_t pixels) {
        CutProfile profile(options, pixels);
        Walker& walker = begin_walk();
        ProfiledLevel level, next;
        level.nodes.push_back(root_opening(v)), level.steps.push_back(CutProfile::kSteps);
        double weight = 1;
        while (!level.nodes.empty()) {
            next.clear();
            for (std::span<const Opening> rest = level.nodes, nodes; !rest.empty();
                 rest = rest.subspan(nodes.size())) {
                nodes = first_chunk(rest);
                const int* steps = level.steps.data() + (nodes.data() - level.nodes.data());
                profile_nodes(nodes, steps, weight, v, walker, profile, next);
            }
            weight = thin_out(next, weight, profile, options);
            for (const Opening& node : next.nodes) model.prefetch({node.block, node.slot});
            std::swap(level, next);
        }
        profile.finish();
        return profile;
    }

    // Leaves out nodes that only cuts beyond the limit open, and of the others all but every n-th.  Returns
    // the weight of those that are left.
    static double thin_out(ProfiledLevel& level, double weight, CutProfile& profile,
                           const ProfileOptions& options) {
        profile.limit(level.steps, weight);
        size_t kept = 0;
        for (size_t i = 0; i < level.nodes.size(); ++i)
            if (level.steps[i] > profile.first_step()) level.keep(i, kept++);
        const size_t stride = (kept + options.samples - 1) / options.samples;
        if (stride > 1) {
            size_t sampled = 0;
            for (size_t i = stride / 2; i < kept; i += stride) level.keep(i, sampled++);
            weight *= double(kept) / double(sampled);
            kept = sampled;
        }
        level.shorten(kept);
        return weight;
    }
};

Cut::Cut(const Model& model) : state_(std::make_unique<State>(model)) {}
Cut::~Cut() = default;

size_t Cut::begin(const geom::View& view, const CutOptions& options, double unit) {
    state_->view = make_cut_view(state_->model, view, options);
    state_->view.unit = float(unit);
    // Stamps of 256 frames ago become one that is no frame's; 0 stays: never used.
    if (++state_->frame == 0) {
        for (uint64_t b = 0; b < state_->model.blocks_present(); ++b)
            if (state_->touched[b].load(std::memory_order_relaxed) != 0)
                state_->touched[b].store(1, std::memory_order_relaxed);
        state_->frame = 2;
    }
    state_->walk_top();
    if (view.width != view.picture_width() || view.height != view.picture_height())
        state_->narrow_to_raster();
    if (state_->outlines.size() < state_->tasks.size()) state_->outlines.resize(state_->tasks.size());
    for (TaskOutlines& made : state_->outlines) made.count = 0;
    state_->counts = state_->top_counts;
    return std::max<size_t>(1, state_->tasks.size());
}

void Cut::outline(size_t task, geom::OcclusionMap& map) {
    if (task >= state_->tasks.size()) return;
    CutCounts c;
    state_->outline(task, map, c);
    state_->add(c);
}

Cut::Sifted Cut::sift(size_t task, geom::OcclusionMap& map) {
    if (task >= state_->tasks.size()) return {};
    Outline& outline = state_->outlines[task].last();
    outline.sights.clear();
    Sifted sifted{outline.level.size(), 0};
    for (const Opening& node : outline.level) {
        outline.sights.push_back(state_->look(node.at, node.radius, map));
        sifted.hidden += outline.sights.back() == geom::OcclusionMap::Sight::hidden;
    }
    return sifted;
}

void Cut::run(size_t task, const Sink& sink, geom::OcclusionMap* map, const TriangleSink& triangles) {
    CutCounts c;
    if (task == 0) {
        for (const geom::SplatBatch& batch : state_->top_batches) sink(batch);
        for (const geom::TriangleBatch& batch : state_->top_triangles) triangles(batch);
    }
    if (task < state_->tasks.size()) state_->walk_task(task, {sink, triangles}, map, c);
    state_->add(c);
}

CutCounts Cut::counts() const { return state_->counts; }

CutPlan Cut::plan() const {
    return state_->view.plan;
}

CutProfile Cut::profile(const geom::View& view, const CutOptions& options,
                        const ProfileOptions& limits) const {
    CutView v = make_cut_view(state_->model, view, options);
    v.is_profiled = true;
    v.sides = v.raster_sides;
    return state_->profile(v, limits, uint64_t(view.width) * uint64_t(view.height));
}

}  // namespace splat
#endif
