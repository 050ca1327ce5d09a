// Set-up of splats, as many at a time as the machine's vectors hold.
#include "render/splat_record.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

// Vectors are members of structs here, which those of unknown length cannot be; ARM has NEON as well.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/splat_setup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/shading-inl.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

using F = hn::ScalableTag<float>;
using V = hn::Vec<F>;
using U = hn::RebindToUnsigned<F>;
constexpr size_t kMaxLanes = hn::MaxLanes(F());

// Thickness of a splat's core, in that of the splat.
constexpr float kCoreFlatness = 0.1f;

// No radius in pixels is less: squares of it stay within float.
constexpr float kMinRadiusPx = 1.0e-5f;

// hn::Iota() writes its lanes one by one and reads them back as a vector, which waits for all of them.
struct LaneNumbers {
    alignas(64) uint32_t of[kMaxLanes];
};
constexpr LaneNumbers kLaneNumbers = [] {
    LaneNumbers all{};
    for (uint32_t i = 0; i < kMaxLanes; ++i) all.of[i] = i;
    return all;
}();

// F's lanes in double, in two vectors (the one lane of the scalar target in each).
#if HWY_TARGET == HWY_SCALAR
using DF = hn::Rebind<double, F>;
#else
using DF = hn::RepartitionToWide<F>;
#endif

struct DoubleLanes {
    hn::Vec<DF> low, high;
};

HWY_INLINE DoubleLanes promote(V v) {
#if HWY_TARGET == HWY_SCALAR
    return {hn::PromoteTo(DF(), v), hn::PromoteTo(DF(), v)};
#else
    const hn::Half<F> half;
    return {hn::PromoteTo(DF(), hn::LowerHalf(half, v)), hn::PromoteTo(DF(), hn::UpperHalf(half, v))};
#endif
}

HWY_INLINE V demote(DoubleLanes v) {
#if HWY_TARGET == HWY_SCALAR
    return hn::DemoteTo(F(), v.low);
#else
    const hn::Half<F> half;
    return hn::Combine(F(), hn::DemoteTo(half, v.high), hn::DemoteTo(half, v.low));
#endif
}

HWY_INLINE DoubleLanes multiply(DoubleLanes a, DoubleLanes b) {
    return {hn::Mul(a.low, b.low), hn::Mul(a.high, b.high)};
}

HWY_INLINE DoubleLanes scale(DoubleLanes a, double s) {
    const auto factor = hn::Set(DF(), s);
    return {hn::Mul(a.low, factor), hn::Mul(a.high, factor)};
}

HWY_INLINE DoubleLanes add(DoubleLanes a, double s) {
    const auto summand = hn::Set(DF(), s);
    return {hn::Add(a.low, summand), hn::Add(a.high, summand)};
}

HWY_INLINE V square(V v) {
    return hn::Mul(v, v);
}

// Outline and depth of N splats; offsets and extents in pixels about the projection of the centre.
struct Outline {
    V centre_dx, centre_dy;
    V extent_x, extent_y;
    V l1, l2, l3;
    V w, w_dx, w_dy;
    V clearance;  // > 0: wholly before the eye (or wholly behind it)
    V core_a, core_b;
};

// The core's covariance is less than the outline's by a multiple of m m^T, m being the projected normal (an,
// bn); with u = m in the outline's frame its inverse there is 1 + u u^T / (1 - u.u).
HWY_INLINE void set_core(Outline& o, V half_thickness_px, V an, V bn) {
    const F d;
    const V thinned = hn::Mul(half_thickness_px, hn::Set(d, std::sqrt(1 - kCoreFlatness * kCoreFlatness)));
    const V u_a = hn::Mul(thinned, hn::Add(hn::Mul(o.l1, an), hn::Mul(o.l2, bn)));
    const V u_b = hn::Mul(thinned, hn::Mul(o.l3, bn));
    const V rest = hn::Sub(hn::Set(d, 1.0f), hn::Add(square(u_a), square(u_b)));
    const V least = hn::Set(d, kCoreFlatness * kCoreFlatness);
    const V inverse = hn::Div(hn::Set(d, kCoreScale), hn::Sqrt(hn::Max(rest, least)));
    // Close to the eye perspective has its part in the covariance, and u may be longer than it should.
    const V most = hn::Set(d, 32767.0f);
    o.core_a = hn::Clamp(hn::Mul(u_a, inverse), hn::Neg(most), most);
    o.core_b = hn::Clamp(hn::Mul(u_b, inverse), hn::Neg(most), most);
}

// With P = p/z, r = R/z, c = rho^2 the ellipsoid is the set of planes (dual quadric) r^2 S - P P^T,
// S = 1 - (1 - c) n n^T, and its outline's dual conic is that matrix itself.  With D = 1 - r^2 S_zz,
// a = (1, 0, -P_x), b = (0, 1, -P_y), the outline has its centre at P_xy + r^2 (P_xy S_zz - S_xy,z) / D and
//     covariance  r^2/D^2 [[aSa - r^2 (SxxSzz - Sxz^2), ...]],    determinant  r^4/D^3 (s - c r^2),
// s = c P.P + (1 - c) (n.P)^2.  Each of these is written as a sum of squares (aSa = |a x n|^2 + c (a.n)^2),
// so that the only difference left is the one that vanishes where the splat reaches the eye's plane.
HWY_INLINE Outline ellipsoid_outline(float focal_px, V tx, V ty, V inverse_z, V r, V radius_px, V nx, V ny,
                                     V nz, V flatness, bool has_core) {
    const F d;
    const V one = hn::Set(d, 1.0f);
    const V tiny = hn::Set(d, 1.0e-30f);
    const V c = square(hn::Max(flatness, hn::Set(d, kMinFlatness)));
    const V g = hn::Sub(one, c);
    const V r2 = square(r);
    const V nx2 = square(nx), ny2 = square(ny), nz2 = square(nz);

    const V szz = hn::Add(hn::Add(nx2, ny2), hn::Mul(c, nz2));
    const V clearance = hn::Sub(one, hn::Mul(r2, szz));
    const V inverse_clearance = hn::Div(one, clearance);
    const V shift = hn::Mul(r2, inverse_clearance);
    const V ex = hn::Mul(shift, hn::Add(hn::Mul(tx, szz), hn::Mul(g, hn::Mul(nx, nz))));
    const V ey = hn::Mul(shift, hn::Add(hn::Mul(ty, szz), hn::Mul(g, hn::Mul(ny, nz))));

    // a x n = (tx ny, -ax, ny), b x n = (by, -ty nx, -nx).
    const V ax = hn::Add(nz, hn::Mul(tx, nx)), by = hn::Add(nz, hn::Mul(ty, ny));
    const V an = hn::Sub(nx, hn::Mul(tx, nz)), bn = hn::Sub(ny, hn::Mul(ty, nz));
    const V asa =
        hn::Add(hn::Add(hn::Mul(ny2, hn::Add(one, square(tx))), square(ax)), hn::Mul(c, square(an)));
    const V bsb =
        hn::Add(hn::Add(hn::Mul(nx2, hn::Add(one, square(ty))), square(by)), hn::Mul(c, square(bn)));
    const V asb =
        hn::Add(hn::Sub(hn::Add(hn::Mul(hn::Mul(tx, ny), by), hn::Mul(hn::Mul(ty, nx), ax)), hn::Mul(nx, ny)),
                hn::Mul(c, hn::Mul(an, bn)));
    const V vxx = hn::Max(hn::Sub(asa, hn::Mul(r2, hn::Add(ny2, hn::Mul(c, hn::Add(nx2, nz2))))), tiny);
    const V vyy = hn::Max(hn::Sub(bsb, hn::Mul(r2, hn::Add(nx2, hn::Mul(c, hn::Add(ny2, nz2))))), tiny);
    const V vxy = hn::Add(asb, hn::Mul(r2, hn::Mul(g, hn::Mul(nx, ny))));

    const V np = hn::Add(hn::Add(hn::Mul(nx, tx), hn::Mul(ny, ty)), nz);
    const V pp = hn::Add(hn::Add(square(tx), square(ty)), one);
    const V s = hn::Add(hn::Mul(c, pp), hn::Mul(g, square(np)));
    const V det = hn::Max(hn::Sub(s, hn::Mul(c, r2)), tiny);

    Outline o;
    const V focal = hn::Set(d, focal_px);
    const V scale_px = hn::Mul(radius_px, inverse_clearance);
    // The second is the eye's own distance from the ellipsoid, to which the outline's size is as sensitive.
    o.clearance = hn::Min(clearance, hn::Div(det, s));
    o.centre_dx = hn::Mul(ex, focal);
    o.centre_dy = hn::Mul(ey, focal);
    o.extent_x = hn::Mul(scale_px, hn::Sqrt(vxx));
    o.extent_y = hn::Mul(scale_px, hn::Sqrt(vyy));

    // Cholesky factor of the inverse covariance.
    const V edge = hn::Set(d, (1.0f - 0.5f * kEdge) * (1.0f - kGrowth));
    const V inverse_radius_px = hn::Div(edge, radius_px);
    const V k = hn::Mul(hn::Sqrt(hn::Div(clearance, hn::Mul(vyy, det))), inverse_radius_px);
    o.l1 = hn::Mul(vyy, k);
    o.l2 = hn::Neg(hn::Mul(vxy, k));
    o.l3 = hn::Div(edge, o.extent_y);

    if (has_core) {
        set_core(o, hn::Mul(scale_px, hn::Sqrt(c)), an, bn);
    } else {
        o.core_a = o.core_b = hn::Zero(d);
    }

    // Polar plane: 1/z = (1 + e.u/s) / z0 with u = c P + (1 - c) (n.P) n.
    const V gnp = hn::Mul(g, np);
    const V inverse_s = hn::Div(one, s);
    const V ux = hn::Mul(inverse_s, hn::Add(hn::Mul(c, tx), hn::Mul(gnp, nx)));
    const V uy = hn::Mul(inverse_s, hn::Add(hn::Mul(c, ty), hn::Mul(gnp, ny)));
    const V inverse_z_px = hn::Mul(inverse_z, hn::Set(d, 1.0f / focal_px));
    o.w = hn::Mul(inverse_z, hn::Add(one, hn::Add(hn::Mul(ex, ux), hn::Mul(ey, uy))));
    o.w_dx = hn::Mul(inverse_z_px, ux);
    o.w_dy = hn::Mul(inverse_z_px, uy);
    return o;
}

// Screen-aligned: depth of the centre everywhere.
HWY_INLINE Outline aligned_outline(V inverse_z, V radius_px, bool square_kind) {
    const F d;
    Outline o;
    const V zero = hn::Zero(d);
    o.clearance = hn::Set(d, 1.0f);
    o.centre_dx = o.centre_dy = zero;
    o.extent_x = o.extent_y = radius_px;
    const float edge = square_kind ? 1.0f : 1.0f - 0.5f * kEdge;
    o.l1 = o.l3 = hn::Div(hn::Set(d, edge), radius_px);
    o.l2 = zero;
    o.w = inverse_z;
    o.w_dx = o.w_dy = zero;
    o.core_a = o.core_b = zero;
    return o;
}

// First and last pixel whose centres lie within `extent` of `centre`, of `size` pixels from `begin` on.
struct PixelRange {
    V first, last;
    hn::Mask<F> any;
};

HWY_INLINE PixelRange pixel_range(V centre, V extent, int begin, int size) {
    const F d;
    const V least = hn::Set(d, static_cast<float>(begin)),
            most = hn::Set(d, static_cast<float>(begin + size - 1));
    // What float can be off by at that place, and more.
    const float off_by = 1.0e-4f + static_cast<float>(begin + size) * 3.0e-7f;
    const V reach = hn::Add(hn::Mul(extent, hn::Set(d, 1.0001f)), hn::Set(d, off_by));
    const V middle = hn::Sub(centre, hn::Set(d, 0.5f));
    const V low = hn::Sub(middle, reach), high = hn::Add(middle, reach);
    const auto valid = hn::And(hn::Le(low, most), hn::Ge(high, least));  // false for NaN
    PixelRange range;
    range.first = hn::Ceil(hn::Max(hn::IfThenElse(valid, low, least), least));
    range.last = hn::Floor(hn::Min(hn::IfThenElse(valid, high, least), most));
    range.any = hn::And(valid, hn::Le(range.first, range.last));
    return range;
}

// Offset of pixel `first` from the outline's centre.  The centre comes in double: at pixel 1000 a float has
// but 6e-5 px, too coarse for the smallest splats.
HWY_INLINE V offset_px(V first, DoubleLanes projected, V centre_shift, double principal) {
    const DoubleLanes p = add(promote(first), 0.5 - principal);
    return hn::Sub(demote({hn::Sub(p.low, projected.low), hn::Sub(p.high, projected.high)}), centre_shift);
}

HWY_INLINE hn::Vec<U> pack_pixels(V x, V y) {
    const hn::RebindToSigned<F> di;
    const auto xi = hn::BitCast(U(), hn::ConvertTo(di, x));
    const auto yi = hn::BitCast(U(), hn::ConvertTo(di, y));
    return hn::Or(xi, hn::ShiftLeft<16>(yi));
}

HWY_INLINE hn::Vec<U> pack_cores(V a, V b) {
    const hn::RebindToSigned<F> di;
    const auto ai = hn::BitCast(U(), hn::ConvertTo(di, a));
    const auto bi = hn::BitCast(U(), hn::ConvertTo(di, b));
    return hn::Or(hn::And(ai, hn::Set(U(), 0xffffu)), hn::ShiftLeft<16>(bi));
}

// The sphere of its radius meets all four half-spaces that bound the raster.
bool may_be_seen(const geom::View& view, double x, double y, double z, double radius) {
    const glm::dvec2 principal = view.principal_in_raster();
    // How far the centre is beyond the side where f * coordinate = place * z.
    const auto off = [&](double coordinate, double place) {
        return (coordinate * view.focal_px - place * z) / std::hypot(view.focal_px, place);
    };
    return off(-x, principal.x) <= radius && off(x, view.width - principal.x) <= radius &&
           off(-y, principal.y) <= radius && off(y, view.height - principal.y) <= radius;
}

struct PixelBox {
    uint16_t x0, y0, x1, y1;
};

NearSplat near_splat(const SplatChunk& chunk, size_t i, const PixelBox& box, uint32_t colour) {
    const float *place = chunk.place + 4 * i, *facing = chunk.facing + 4 * i;
    const double inverse = 1.0 / static_cast<double>(place[3]);
    const float c = std::max(facing[3], kMinFlatness);
    return {box.x0,
            box.y0,
            box.x1,
            box.y1,
            static_cast<float>(place[0] * inverse),
            static_cast<float>(place[1] * inverse),
            static_cast<float>(place[2] * inverse),
            facing[0],
            facing[1],
            facing[2],
            c * c,
            static_cast<float>(inverse),
            colour};
}

// Material of each splat: what `smooth` blends, and what the others are shaded with.
HWY_INLINE Rgb<V> material_of(bool has_colour, hn::Vec<U> colour) {
    const F d;
    if (has_colour) return unpack_rgb(d, colour);
    const V grey = hn::Set(d, kGreyMaterial);
    return {grey, grey, grey};
}

// Bit i is lane i.
template <class Mask>
HWY_INLINE uint32_t mask_bits(Mask mask) {
    static_assert(kMaxLanes <= 32);
    uint8_t bytes[8] = {};
    hn::StoreMaskBits(F(), mask, bytes);
    uint32_t bits;
    std::memcpy(&bits, bytes, sizeof(bits));
    return bits;
}

// Records lie as four vectors of four floats; this is how many lanes there are of each.
template <class Visible>
HWY_INLINE size_t write_records(const V (&fields)[16], Visible visible, SplatRecord* out) {
    const F d;
#if HWY_TARGET == HWY_SCALAR
    if (hn::AllFalse(d, visible)) return 0;
    for (size_t f = 0; f < 16; ++f) hn::Store(fields[f], d, reinterpret_cast<float*>(out) + f);
    return 1;
#else
    alignas(64) float quarters[4][4 * kMaxLanes];
    for (size_t q = 0; q < 4; ++q) {
        hn::StoreInterleaved4(fields[4 * q], fields[4 * q + 1], fields[4 * q + 2], fields[4 * q + 3], d,
                              quarters[q]);
    }
    size_t count = 0;
    for (uint32_t bits = mask_bits(visible); bits != 0; bits &= bits - 1) {
        const size_t lane = static_cast<size_t>(std::countr_zero(bits));
        float* record = reinterpret_cast<float*>(out + count++);
        const hn::FixedTag<float, 4> quarter;
        for (size_t q = 0; q < 4; ++q) {
            hn::Store(hn::Load(quarter, quarters[q] + 4 * lane), quarter, record + 4 * q);
        }
    }
    return count;
#endif
}

size_t set_up_splats(const SetupParams& params, const SplatChunk& chunk, size_t count,
                     const uint32_t* colours, SplatRecord* out, std::vector<NearSplat>& near_splats) {
    const F d;
    const U du;
    const geom::View& view = params.view;
    const SplatterOptions& options = params.options;
    const bool aligned = options.kind == SplatKind::square || options.kind == SplatKind::circle;
    const bool blended = options.kind == SplatKind::smooth;
    const bool has_colour = options.has_colour || options.look.shade == Shade::level;
    const float focal = static_cast<float>(view.focal_px);
    // All that becomes part of a record is about the picture, so that it does not depend on the raster.
    const glm::dvec2 principal = view.principal();
    const int width = view.picture_width(), height = view.picture_height();
    size_t written = 0;

    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        V x, y, z, radius, nx, ny, nz, flatness;
        hn::LoadInterleaved4(d, chunk.place + 4 * i, x, y, z, radius);
        hn::LoadInterleaved4(d, chunk.facing + 4 * i, nx, ny, nz, flatness);
        const DoubleLanes zd = promote(z);
        const auto one_d = hn::Set(DF(), 1.0);
        const DoubleLanes inverse_zd = {hn::Div(one_d, zd.low), hn::Div(one_d, zd.high)};
        const DoubleLanes txd = multiply(promote(x), inverse_zd);
        const DoubleLanes tyd = multiply(promote(y), inverse_zd);
        const DoubleLanes projected_x = scale(txd, view.focal_px), projected_y = scale(tyd, view.focal_px);
        const V inverse_z = demote(inverse_zd);
        const V r = hn::Mul(radius, inverse_z);
        const V radius_px = hn::Max(hn::Mul(r, hn::Set(d, focal)), hn::Set(d, kMinRadiusPx));

        const Outline o = aligned ? aligned_outline(inverse_z, radius_px, options.kind == SplatKind::square)
                                  : ellipsoid_outline(focal, demote(txd), demote(tyd), inverse_z, r,
                                                      radius_px, nx, ny, nz, flatness, params.has_cores());

        const PixelRange xs = pixel_range(
            hn::Add(hn::Add(demote(projected_x), o.centre_dx), hn::Set(d, static_cast<float>(principal.x))),
            o.extent_x, 0, width);
        const PixelRange ys = pixel_range(
            hn::Add(hn::Add(demote(projected_y), o.centre_dy), hn::Set(d, static_cast<float>(principal.y))),
            o.extent_y, 0, height);
        const auto valid = hn::FirstN(d, count - i);
        const auto before_eye = hn::Gt(z, hn::Zero(d));
        const auto clear = hn::Gt(o.clearance, hn::Set(d, kMinClearance));
        const auto visible = hn::And(hn::And(valid, hn::And(before_eye, clear)), hn::And(xs.any, ys.any));

        // Of splats without colour nobody wrote any: reading it would wait for memory.
        const auto given = has_colour ? hn::Load(du, colours + i) : hn::Zero(du);
        const auto colour = blended ? given
                                    : shade_points(d, options.look.shade, params.light, nx, ny, nz,
                                                   material_of(has_colour, given));

        // 1/z - 1/(z + R cos): R along the ray, which off the axis is less of depth.  A push of 0 makes the aligned
        // kinds a plain depth test.
        const V tx = demote(txd), ty = demote(tyd), one = hn::Set(d, 1.0f);
        const V along_ray = hn::Div(r, hn::Sqrt(hn::Add(one, hn::Add(hn::Mul(tx, tx), hn::Mul(ty, ty)))));
        const V push = aligned ? hn::Zero(d) : hn::Mul(inverse_z, hn::Div(along_ray, hn::Add(one, along_ray)));
        const V fields[16] = {hn::BitCast(d, pack_pixels(xs.first, ys.first)),
                              hn::BitCast(d, pack_pixels(xs.last, ys.last)),
                              offset_px(xs.first, projected_x, o.centre_dx, principal.x),
                              offset_px(ys.first, projected_y, o.centre_dy, principal.y),
                              o.l1,
                              o.l2,
                              o.l3,
                              push,
                              o.w,
                              o.w_dx,
                              o.w_dy,
                              hn::BitCast(d, colour),
                              nx,
                              ny,
                              nz,
                              hn::BitCast(d, pack_cores(o.core_a, o.core_b))};
        written += write_records(fields, visible, out + written);

        if (aligned) continue;
        // Written so that a clearance that is no number (z of 0) takes the careful way.
        const auto behind = hn::AndNot(before_eye, hn::Ge(o.clearance, hn::Zero(d)));
        const auto careful = hn::AndNot(hn::Or(behind, hn::And(before_eye, clear)), valid);
        if (hn::AllFalse(d, careful)) continue;
        const auto bounded = hn::And(before_eye, hn::Gt(o.clearance, hn::Set(d, kMinBoundedClearance)));
        const auto off_screen = hn::AndNot(hn::And(xs.any, ys.any), bounded);
        alignas(64) float x0[kMaxLanes], y0[kMaxLanes], x1[kMaxLanes], y1[kMaxLanes];
        alignas(64) uint32_t lane_colours[kMaxLanes];
        hn::Store(hn::IfThenElseZero(bounded, xs.first), d, x0);
        hn::Store(hn::IfThenElseZero(bounded, ys.first), d, y0);
        hn::Store(hn::IfThenElse(bounded, xs.last, hn::Set(d, static_cast<float>(width - 1))), d, x1);
        hn::Store(hn::IfThenElse(bounded, ys.last, hn::Set(d, static_cast<float>(height - 1))), d, y1);
        hn::Store(colour, du, lane_colours);
        for (uint32_t bits = mask_bits(hn::AndNot(off_screen, careful)); bits != 0; bits &= bits - 1) {
            const size_t lane = static_cast<size_t>(std::countr_zero(bits)), k = i + lane;
            const float* place = chunk.place + 4 * k;
            if (!may_be_seen(view, place[0], place[1], place[2], place[3])) continue;
            const PixelBox seen{uint16_t(x0[lane]), uint16_t(y0[lane]), uint16_t(x1[lane]),
                                uint16_t(y1[lane])};
            near_splats.push_back(near_splat(chunk, k, seen, lane_colours[lane]));
        }
    }
    return written;
}

// Splats farther away than this many radii are wholly before the eye, whatever their shape.
constexpr float kClearRadii = 2;

// A bound on half the width along x of a splat's outline about its centre's projection, at focal length 1,
// for r = R/z <= 1/2: as in ellipsoid_outline(), without what makes it narrower.  t: tx; g: 1 - rho^2.
HWY_INLINE V outline_reach(V r, V t, V g, V nx, V nz) {
    const F d;
    const V one = hn::Set(d, 1.0f), r2 = square(r);
    // 1 / (1 - r^2 S_zz) at most, and what the differences below can be off by.
    const V inverse_clearance = hn::Add(one, hn::Mul(hn::Set(d, 4.0f / 3.0f), r2));
    const V slack = hn::Set(d, 1.0e-5f);
    const V t2 = hn::Add(one, square(t));
    const V asa = hn::Sub(t2, hn::Mul(g, square(hn::Sub(nx, hn::Mul(t, nz)))));
    const V half = hn::Sqrt(hn::Add(hn::Max(asa, hn::Zero(d)), hn::Mul(slack, t2)));
    const V shift = hn::Mul(r2, hn::Add(one, hn::Abs(t)));
    return hn::Mul(inverse_clearance, hn::Add(hn::Mul(r, half), shift));
}

// Pixels, as pack_pixels(), to tiles.
HWY_INLINE hn::Vec<U> tiles_of(hn::Vec<U> pixels) {
    constexpr int kShiftX = std::countr_zero(unsigned(kTileWidth)),
                  kShiftY = std::countr_zero(unsigned(kTileHeight));
    const U du;
    const auto x = hn::ShiftRight<kShiftX>(hn::And(pixels, hn::Set(du, 0xffffu)));
    const auto y = hn::ShiftRight<16 + kShiftY>(pixels);
    return hn::Or(x, hn::ShiftLeft<16>(y));
}

// A batch on its way to the bins.
struct SplatsToBin {
    alignas(64) float place[4 * SplatBatch::kCapacity], facing[4 * SplatBatch::kCapacity];
    // Tiles that each may lie in, counted from the raster's first: x, and y in the high half; and the first
    // of them by number.
    alignas(64) uint32_t first[SplatBatch::kCapacity], last[SplatBatch::kCapacity],
        tile[SplatBatch::kCapacity];
    // Those to be binned, kWide and kClose being added to their indices.
    uint32_t list[SplatBatch::kCapacity + kMaxLanes];
    size_t count = 0;
    static constexpr uint32_t kWide = 1u << 30;   // in more than one tile
    static constexpr uint32_t kClose = 1u << 31;  // may reach to the eye's plane
};

// A splat that may reach to the eye's plane: its set-up says what it is, and which tiles it lies in.
HWY_NOINLINE bool look_closely(const SetupParams& params, size_t i, uint32_t colour, SplatsToBin& splats,
                               std::vector<NearSplat>& near_splats) {
    SplatChunk one;
    std::memcpy(one.place, splats.place + 4 * i, sizeof(float) * 4);
    std::memcpy(one.facing, splats.facing + 4 * i, sizeof(float) * 4);
    ColourChunk colours;
    colours.of[0] = colour;
    SplatRecord record;
    if (set_up_splats(params, one, 1, colours.of, &record, near_splats) == 0) return false;
    const geom::View& view = params.view;
    const int left = view.margins.left, right = left + view.width - 1;
    const int top = view.margins.top, bottom = top + view.height - 1;
    if (record.x1 < left || record.x0 > right || record.y1 < top || record.y0 > bottom) return false;
    const TileGrid grid(view);
    const auto tile = [&](int x, int y) {
        return uint32_t(x / kTileWidth - grid.left) | uint32_t(y / kTileHeight - grid.top) << 16;
    };
    splats.first[i] = tile(std::max<int>(record.x0, left), std::max<int>(record.y0, top));
    splats.last[i] = tile(std::min<int>(record.x1, right), std::min<int>(record.y1, bottom));
    return true;
}

// Finds the tiles of a batch's splats.
HWY_INLINE void find_tiles(const SetupParams& params, int tiles_across, const SplatBatch& batch,
                           SplatsToBin& out) {
    const F d;
    const U du;
    const geom::View& view = params.view;
    const bool aligned = params.options.kind == SplatKind::square || params.options.kind == SplatKind::circle;
    const V one = hn::Set(d, 1.0f), focal = hn::Set(d, static_cast<float>(view.focal_px));
    const glm::dvec2 principal = view.principal();
    const TileGrid grid(view);
    const auto first_tile =
        hn::Set(du, static_cast<uint32_t>(grid.left) | static_cast<uint32_t>(grid.top) << 16);
    const size_t count = static_cast<size_t>(batch.count);
    for (size_t i = 0; i < count; i += hn::Lanes(d)) {
        const V x = hn::Load(d, batch.x + i), y = hn::Load(d, batch.y + i), z = hn::Load(d, batch.z + i);
        const V radius = hn::Load(d, batch.radius + i), flatness = hn::Load(d, batch.flatness + i);
        const V nx = hn::Load(d, batch.nx + i), ny = hn::Load(d, batch.ny + i),
                nz = hn::Load(d, batch.nz + i);
        const V inverse_z = hn::Div(one, z);
        const V r = hn::Mul(radius, inverse_z);
        const V g = aligned ? hn::Zero(d) : hn::Sub(one, square(flatness));  // 0: as wide as its sphere
        const auto range = [&](V t, V n, double middle, int begin, int size) HWY_ATTR {
            const V centre = hn::Add(hn::Mul(t, focal), hn::Set(d, static_cast<float>(middle)));
            // Larger by more than float can be off by.
            const V extent = hn::Mul(hn::Mul(focal, outline_reach(r, t, g, n, nz)), hn::Set(d, 1.001f));
            const V off_by = hn::Set(d, 1.0e-3f + static_cast<float>(begin + size) * 1.0e-6f);
            return pixel_range(centre, hn::Add(extent, off_by), begin, size);
        };
        const PixelRange xs = range(hn::Mul(x, inverse_z), nx, principal.x, view.margins.left, view.width);
        const PixelRange ys = range(hn::Mul(y, inverse_z), ny, principal.y, view.margins.top, view.height);
        const auto clear = hn::Gt(z, hn::Mul(radius, hn::Set(d, kClearRadii)));  // false for NaN
        const auto unseen = hn::And(clear, hn::Not(hn::And(xs.any, ys.any)));
        const auto wanted = hn::RebindMask(du, hn::AndNot(unseen, hn::FirstN(d, count - i)));

        const auto first = hn::Sub(tiles_of(pack_pixels(xs.first, ys.first)), first_tile),
                   last = hn::Sub(tiles_of(pack_pixels(xs.last, ys.last)), first_tile);
        const auto row = hn::Mul(hn::ShiftRight<16>(first), hn::Set(du, static_cast<uint32_t>(tiles_across)));
        hn::Store(first, du, out.first + i);
        hn::Store(last, du, out.last + i);
        hn::Store(hn::Add(row, hn::And(first, hn::Set(du, 0xffffu))), du, out.tile + i);
        hn::StoreInterleaved4(x, y, z, radius, d, out.place + 4 * i);
        hn::StoreInterleaved4(nx, ny, nz, flatness, d, out.facing + 4 * i);
        const auto close_flag =
            hn::IfThenZeroElse(hn::RebindMask(du, clear), hn::Set(du, SplatsToBin::kClose));
        const auto wide_flag = hn::IfThenZeroElse(hn::Eq(first, last), hn::Set(du, SplatsToBin::kWide));
        const auto item = hn::Or(hn::Or(hn::Load(du, kLaneNumbers.of), hn::Set(du, static_cast<uint32_t>(i))),
                                 hn::Or(close_flag, wide_flag));
        hn::StoreU(hn::Compress(item, wanted), du, out.list + out.count);
        out.count += hn::CountTrue(du, wanted);
    }
}

void bin_splats(const SetupParams& params, const SplatBatch& batch, const uint32_t* colours, TileBins& bins,
                std::vector<TileRun>& runs, std::vector<NearSplat>& near_splats) {
    SplatsToBin splats;
    const uint32_t across = static_cast<uint32_t>(bins.tiles_across());
    find_tiles(params, bins.tiles_across(), batch, splats);
    const bool has_colour = params.options.has_colour;
    const auto put = [&](size_t i, uint32_t tile) {
        const TileBins::Place to = bins.next(tile, runs);
        std::memcpy(to.chunk->place + 4 * to.at, splats.place + 4 * i, sizeof(float) * 4);
        std::memcpy(to.chunk->facing + 4 * to.at, splats.facing + 4 * i, sizeof(float) * 4);
        if (has_colour) to.colours->of[to.at] = batch.colour[i];
    };
    for (size_t n = 0; n < splats.count; ++n) {
        const uint32_t item = splats.list[n];
        const size_t i = item & (SplatsToBin::kWide - 1);
        if (item < SplatsToBin::kWide) {  // nearly all
            put(i, splats.tile[i]);
            continue;
        }
        if ((item & SplatsToBin::kClose) && !look_closely(params, i, colours[i], splats, near_splats))
            continue;
        for (uint32_t y = splats.first[i] >> 16; y <= splats.last[i] >> 16; ++y) {
            for (uint32_t x = splats.first[i] & 0xffffu; x <= (splats.last[i] & 0xffffu); ++x)
                put(i, y * across + x);
        }
    }
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace render {

HWY_EXPORT(set_up_splats);
HWY_EXPORT(bin_splats);

namespace {

// Shade::level colours a splat by its size.
uint32_t colour_of_level(const SetupParams& params, float z, float radius) {
    const double focal_px = params.view.focal_px / params.options.look.samples_across;
    const double diameter = 2.0 * focal_px * radius / std::abs(double(z));
    const glm::u8vec3 c = level_colour(static_cast<float>(std::min(diameter, 1.0e6)));
    return uint32_t(c.r) | uint32_t(c.g) << 8 | uint32_t(c.b) << 16;
}

}  // namespace

size_t set_up_splats(const SetupParams& params, const SplatChunk& chunk, const ColourChunk& colours,
                     size_t count, SplatRecord* out, std::vector<NearSplat>& near_splats) {
    ColourChunk levels;
    if (params.options.look.shade == Shade::level) {
        for (size_t i = 0; i < count; ++i)
            levels.of[i] = colour_of_level(params, chunk.place[4 * i + 2], chunk.place[4 * i + 3]);
    }
    const ColourChunk& shown = params.options.look.shade == Shade::level ? levels : colours;
    return HWY_DYNAMIC_DISPATCH(set_up_splats)(params, chunk, count, shown.of, out, near_splats);
}

void bin_splats(const SetupParams& params, const SplatBatch& batch, TileBins& bins,
                std::vector<TileRun>& runs, std::vector<NearSplat>& near_splats) {
    const uint32_t* colours = batch.colour;
    alignas(64) uint32_t levels[SplatBatch::kCapacity];
    if (params.options.look.shade == Shade::level) {
        for (int i = 0; i < batch.count; ++i)
            levels[i] = colour_of_level(params, batch.z[i], batch.radius[i]);
        colours = levels;
    }
    HWY_DYNAMIC_DISPATCH(bin_splats)(params, batch, colours, bins, runs, near_splats);
}

}  // namespace render
#endif
