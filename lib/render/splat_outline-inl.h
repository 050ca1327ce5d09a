// Outlines of splats in the picture, and the pixels within them.
// (Highway per-target header: included once for each instruction set.)
#if defined(RENDER_SPLAT_OUTLINE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RENDER_SPLAT_OUTLINE_INL_H_
#undef RENDER_SPLAT_OUTLINE_INL_H_
#else
#define RENDER_SPLAT_OUTLINE_INL_H_
#endif

#include <hwy/highway.h>
#include <cmath>

#include "render/lanes-inl.h"
#include "render/splat_record.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

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
                                     V nz, V flatness) {
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

    set_core(o, hn::Mul(scale_px, hn::Sqrt(c)), an, bn);

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

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
