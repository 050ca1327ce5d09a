#include "splat/cut/cut_groups.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cut/cut_groups.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/decode-inl.h"

#ifndef QS_SPLAT_CUT_GROUPS_ONCE
#define QS_SPLAT_CUT_GROUPS_ONCE
namespace splat {
namespace {

constexpr int kGroup = 8;  // lanes for a group of up to kMaxFanOut nodes

// kErrorOfRadius, row by row.
constexpr auto kErrorByFlatness = [] {
    struct {
        float of[32];
    } all{};
    for (size_t k = 0; k < 32; ++k) all.of[k] = kErrorOfRadius[k / 8][k % 8];
    return all;
}();
// A table that fills a vector of any length.
template <size_t N>
constexpr auto repeated(const float (&table)[N]) {
    std::array < float, N<kMaxLanes ? kMaxLanes : N> all{};
    for (size_t i = 0; i < all.size(); ++i) all[i] = table[i % N];
    return all;
}
alignas(64) constexpr auto kRadiusTable = repeated(kRadius), kFlatnessTable = repeated(kFlatness),
                           kConeTanTable = repeated(kConeTan), kConeCosTable = repeated(kConeCos),
                           kConeSinTable = repeated(kConeSin);
alignas(64) constexpr auto kErrorTable = repeated(kErrorByFlatness.of);

// hn::Iota() writes its lanes one by one and reads them back as a vector, which waits for all of them.
alignas(64) constexpr auto kLaneNumbers = [] {
    std::array<uint32_t, kMaxLanes> all{};
    for (uint32_t i = 0; i < kMaxLanes; ++i) all[i] = i;
    return all;
}();

}  // namespace
}  // namespace splat
#endif  // QS_SPLAT_CUT_GROUPS_ONCE

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

// Of the `count` splats behind the batch's last one.
HWY_NOINLINE void NoteLargest(V error_px, const geom::SplatBatch& batch, size_t count, CutCounts& counts) {
    alignas(64) float error[kMaxLanes];
    hn::Store(error_px, D(), error);
    for (size_t k = 0; k < count; ++k) {
        const size_t i = size_t(batch.count) + k;
        counts.error_bound_px = std::max(counts.error_bound_px, double(error[k]));
        counts.largest.add({{batch.x[i], batch.y[i], batch.z[i]}, batch.radius[i], error[k]});
    }
}

void CutGroups(std::span<const Opening> parents, const BlockView& block, const CutView& view, Chunk& chunk,
               geom::SplatBatch& batch, CutCounts& counts) {
    const D d;
    const DU du;
    const DI di;
    TakeGroups(parents, block, chunk);
    chunk.open_count = chunk.triangle_count = 0;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const M no_lane = hn::Lt(zero, zero);
    V other_px = zero;  // errors of what is drawn, but for those beyond the threshold
    const V beyond_px = hn::Set(d, view.beyond_px());
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
        const V3 n = DecodeNormal(d, Field(code, 5, 1023), FrameAbout(d, Load3(d, chunk.parent_normal, i)),
                                  cone_tan, any_direction);
        const V3 offset = DecodeOffset(d, place, level, FrameAbout(d, n), parent_radius);
        const V3 at{hn::Add(parent_at.x, offset.x), hn::Add(parent_at.y, offset.y),
                    hn::Add(parent_at.z, offset.z)};
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
        const V square =
            hn::Max(zero, hn::Add(Dot(at, at), hn::Mul(depth, hn::Add(hn::Add(ahead, ahead), depth))));
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
        // Nearest depth of what can be seen of the ellipsoid: where it reaches to the eye's plane beside the
        // view, the picture's corners are still this far ahead.
        const V reach =
            hn::Mul(radius, hn::Sqrt(hn::Max(zero, hn::Sub(one, hn::Mul(hn::Sub(one, hn::Mul(flat, flat)),
                                                                        hn::Mul(facing, facing))))));
        const V length = hn::Sqrt(square);
        const V nearest = hn::Max(
            hn::Set(d, view.near),
            hn::Max(hn::Sub(z, reach), hn::Mul(hn::Sub(length, radius), hn::Set(d, view.corner_cosine))));
        const V focal = hn::Set(d, view.focal);
        // What is drawn is the plane through the centre conjugate to the line of sight: the disc, seen from
        // the front, and up to the half thickness off it where it is seen on edge.
        const V most = hn::Div(hn::Max(zero, hn::Sub(hn::Abs(along), radius)), hn::Add(length, radius));
        const V cos2 = hn::Mul(most, most), lean = hn::Mul(hn::Mul(flat, flat), hn::Sub(one, cos2));
        const V off_disc = hn::Mul(flat, hn::Sqrt(hn::Div(lean, hn::Add(cos2, lean))));
        const U error_at = hn::Or(hn::ShiftLeft<3>(Field(shape, 0, 3)),
                                  hn::Or(hn::ShiftLeft<2>(Field(code, 15, 1)), Field(shape, 2, 3)));
        const V error_of_radius = LookUp<32>(d, kErrorTable, hn::BitCast(di, error_at));
        const V error = hn::Mul(hn::Mul(radius, hn::Add(error_of_radius, off_disc)), focal);
        const V diameter = hn::Mul(hn::Add(radius, radius), focal);
        M small = hn::Le(diameter, hn::Mul(hn::Set(d, view.limit_diameter), nearest));
        if (view.by_error)
            small = hn::And(small, hn::Le(error, hn::Mul(hn::Set(d, view.limit_error), nearest)));
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
            // Where a block has few triangles that are wanted, reading them takes longer than drawing splats,
            // unless they are really large.
            const V limit = hn::Mul(hn::Set(d, view.limit_triangle), nearest);
            const M mostly = hn::Ge(hn::Set(d, block.middle_side() * view.focal),
                                    hn::Mul(limit, hn::Set(d, kSideOfDiameter)));
            const M large = hn::Or(hn::And(mostly, hn::Ge(diameter, limit)),
                                   hn::Ge(diameter, hn::Mul(limit, hn::Set(d, kTrianglesAlone))));
            const M wanted = hn::And(hn::And(drawn, hn::RebindMask(d, leaf)), large);
            const M lacks = hn::And(wanted, hn::RebindMask(d, missing)), found = hn::AndNot(lacks, wanted);
            counts.groups_missing += hn::CountTrue(d, lacks);
            if (!hn::AllFalse(d, found)) {
                const U lane = hn::Iota(du, uint32_t(first));
                hn::StoreU(hn::Compress(lane, hn::RebindMask(du, found)), du,
                           &chunk.triangles[chunk.triangle_count]);
                chunk.triangle_count += uint32_t(hn::CountTrue(d, found));
                const V rounding = hn::Set(d, view.rounding * view.focal);
                const V off = hn::IfThenElse(hn::Gt(nearest, zero), hn::Div(rounding, nearest), hn::Inf(d));
                other_px = hn::Max(other_px, hn::IfThenElseZero(found, off));
                drawn = hn::AndNot(found, drawn);
                if (hn::AllFalse(d, drawn)) continue;
            }
        }
        counts.groups_missing += hn::CountTrue(d, hn::And(is_parent, hn::AndNot(small, drawn)));
        const V safe = hn::IfThenElse(hn::Gt(nearest, zero), hn::Div(error, nearest), hn::Inf(d));
        const M is_beyond = hn::And(drawn, hn::Gt(safe, beyond_px));
        other_px = hn::Max(other_px, hn::IfThenElseZero(hn::AndNot(is_beyond, drawn), safe));
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
        const auto put = [&](V value, float* channel) {
            hn::StoreU(hn::Compress(value, drawn), d, channel + to);
        };
        const V unit = hn::Set(d, view.unit);
        put(hn::Mul(Dot(Set3(d, view.right), at), unit), batch.x);
        put(hn::Mul(Dot(Set3(d, view.down), at), unit), batch.y);
        put(hn::Mul(z, unit), batch.z);
        put(Dot(Set3(d, view.right), shown), batch.nx), put(Dot(Set3(d, view.down), shown), batch.ny),
            put(Dot(forward, shown), batch.nz);
        put(hn::Mul(radius, unit), batch.radius), put(flat, batch.flatness);
        if (view.last_number) {
            const U lane = hn::Add(hn::Load(du, kLaneNumbers.data()), hn::Set(du, uint32_t(first)));
            hn::StoreU(hn::Compress(lane, hn::RebindMask(du, drawn)), du, batch.colour + to);
            hn::Store(safe, d, &chunk.needed[i]);
            hn::Store(hn::IfThenElse(hn::Gt(nearest, zero), hn::Div(diameter, nearest), hn::Inf(d)), d,
                      &chunk.size[i]);
        } else if (view.has_colour)
            hn::StoreU(hn::Compress(DecodeColour(hn::Load(du, &chunk.colour[i])), hn::RebindMask(du, drawn)),
                       du, batch.colour + to);
        else
            hn::StoreU(hn::Set(du, view.colour), du, batch.colour + to);
        if (!hn::AllFalse(d, hn::And(is_beyond, hn::Gt(safe, hn::Set(d, counts.largest.least_px())))))
            NoteLargest(hn::Compress(safe, drawn), batch, hn::CountTrue(d, drawn), counts);
        batch.count += int(hn::CountTrue(d, drawn));
        counts.splats += hn::CountTrue(d, drawn);
        counts.closed += hn::CountTrue(d, hn::AndNot(ends, drawn));
    }
    counts.nodes_visited += uint64_t(chunk.count);
    counts.other_error_px = std::max(counts.other_error_px, double(hn::GetLane(hn::MaxOfLanes(d, other_px))));
    counts.error_bound_px = std::max(counts.error_bound_px, counts.other_error_px);
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace splat {

HWY_EXPORT(CutGroups);

void cut_groups(std::span<const Opening> parents, const BlockView& block, const CutView& view, Chunk& chunk,
                geom::SplatBatch& batch, CutCounts& counts) {
    HWY_DYNAMIC_DISPATCH(CutGroups)(parents, block, view, chunk, batch, counts);
}

}  // namespace splat
#endif
