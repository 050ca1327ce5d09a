// decode_normal(), frame_about() and decode_offset() of node.h, a lane a node: the same operations in the
// same order, so that the same bits come out.  Included once for each SIMD target, by sources that use
// Highway's foreach_target.h.
#if defined(QS_SPLAT_DECODE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QS_SPLAT_DECODE_INL_H
#undef QS_SPLAT_DECODE_INL_H
#else
#define QS_SPLAT_DECODE_INL_H
#endif

#include <hwy/highway.h>

#include "splat/node.h"
#include "splat/vector3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class V>
struct FrameLanes {
    Vector3<V> t1, t2, n;
};
template <class D, class V = hn::Vec<D>>
HWY_INLINE FrameLanes<V> FrameAbout(D d, const Vector3<V>& n) {
    const V one = hn::Set(d, 1.0f);
    const V sign = hn::CopySign(one, n.z);
    const V a = hn::Div(hn::Neg(one), hn::Add(sign, n.z));
    const V b = hn::Mul(hn::Mul(n.x, n.y), a);
    return {{hn::Add(one, hn::Mul(sign, hn::Mul(hn::Mul(n.x, n.x), a))), hn::Mul(sign, b),
             hn::Mul(hn::Neg(sign), n.x)},
            {b, hn::Add(sign, hn::Mul(hn::Mul(n.y, n.y), a)), hn::Neg(n.y)},
            n};
}

// cone_tan: kConeTan of the parent's cone, where it has one.
template <class D, class V = hn::Vec<D>>
HWY_INLINE Vector3<V> DecodeNormal(D d, hn::Vec<hn::Rebind<uint32_t, D>> code, const FrameLanes<V>& parent,
                                   V cone_tan, hn::Mask<D> any_direction) {
    const hn::Rebind<uint32_t, D> du;
    const auto row = hn::ShiftRight<16>(hn::Mul(code, hn::Set(du, 2115u)));  // code / 31
    const auto column = hn::Sub(code, hn::Mul(row, hn::Set(du, uint32_t(kNormalSteps))));
    const V middle = hn::Set(d, 15.0f);
    const hn::RebindToSigned<D> di;
    const auto real = [&](auto v) HWY_ATTR { return hn::ConvertTo(d, hn::BitCast(di, v)); };
    // k / 15, to the bit for the whole numbers from -15 to 15, in less than a division.
    const auto by_15 = [&](V k) HWY_ATTR {
        return hn::Add(hn::Mul(k, hn::Set(d, 1.0f / 16)), hn::Mul(k, hn::Set(d, 1.0f / 240)));
    };
    const V x = by_15(hn::Sub(real(column), middle));
    const V y = by_15(hn::Sub(real(hn::Min(row, hn::Set(du, uint32_t(kNormalSteps - 1)))), middle));
    const V one = hn::Set(d, 1.0f), two = hn::Set(d, 2.0f);
    const V px = hn::Mul(x, cone_tan), py = hn::Mul(y, cone_tan);
    const V q = hn::Add(hn::Mul(px, px), hn::Mul(py, py));
    const V k = hn::Div(one, hn::Add(one, q));
    const Vector3<V> local{hn::Mul(hn::Mul(two, px), k), hn::Mul(hn::Mul(two, py), k),
                           hn::Mul(hn::Sub(one, q), k)};
    Vector3<V> n{Dot(local, Vector3<V>{parent.t1.x, parent.t2.x, parent.n.x}),
                 Dot(local, Vector3<V>{parent.t1.y, parent.t2.y, parent.n.y}),
                 Dot(local, Vector3<V>{parent.t1.z, parent.t2.z, parent.n.z})};
    if (!hn::AllFalse(d, any_direction)) {  // octahedron in model axes
        const V ax = hn::Abs(x), ay = hn::Abs(y);
        const V z = hn::Sub(hn::Sub(one, ax), ay);
        const auto below = hn::Lt(z, hn::Zero(d));
        n.x = hn::IfThenElse(any_direction, hn::IfThenElse(below, hn::CopySign(hn::Sub(one, ay), x), x), n.x);
        n.y = hn::IfThenElse(any_direction, hn::IfThenElse(below, hn::CopySign(hn::Sub(one, ax), y), y), n.y);
        n.z = hn::IfThenElse(any_direction, z, n.z);
    }
    const V s = hn::Div(one, hn::Sqrt(Dot(n, n)));
    return {hn::Mul(n.x, s), hn::Mul(n.y, s), hn::Mul(n.z, s)};
}

// Times the parent's radius.  radius_level: kRadius of the place's level.
template <class D, class V = hn::Vec<D>>
HWY_INLINE Vector3<V> DecodeOffset(D d, hn::Vec<hn::Rebind<uint32_t, D>> place, V radius_level,
                                   const FrameLanes<V>& frame, V parent_radius) {
    const hn::Rebind<uint32_t, D> du;
    const hn::RebindToSigned<D> di;
    const V one = hn::Set(d, 1.0f);
    const auto field = [&](auto v, uint32_t mask) HWY_ATTR {
        return hn::ConvertTo(d, hn::BitCast(di, hn::And(v, hn::Set(du, mask))));
    };
    const auto step = [&](V k, float middle, float scale, float linear) HWY_ATTR {
        const V u = hn::Mul(hn::Sub(k, hn::Set(d, middle)), hn::Set(d, scale));
        return hn::Mul(u, hn::Add(hn::Set(d, linear), hn::Mul(hn::Set(d, 1.0f - linear), hn::Abs(u))));
    };
    const auto across = hn::And(hn::ShiftRight<4>(place), hn::Set(du, 127u));
    const auto row = hn::ShiftRight<11>(hn::Mul(across, hn::Set(du, 187u)));  // across / 11
    const auto column = hn::Sub(across, hn::Mul(row, hn::Set(du, uint32_t(kAcrossSteps))));
    V a = step(field(column, 15), 5.0f, 1.0f / 5.0f, kAcrossLinear);
    V b = step(field(row, 15), 5.0f, 1.0f / 5.0f, kAcrossLinear);
    V c = step(field(hn::ShiftRight<11>(place), 31), 15.5f, 1.0f / 16.0f, kAlongLinear);
    const V q = hn::Add(hn::Add(hn::Mul(a, a), hn::Mul(b, b)), hn::Mul(c, c));
    const V limit = hn::Mul(hn::Set(d, 1.0f + kSlack), hn::Sub(one, radius_level));
    const V s = hn::IfThenElse(hn::Gt(q, one), hn::Div(limit, hn::Sqrt(q)), limit);
    a = hn::Mul(a, s), b = hn::Mul(b, s), c = hn::Mul(c, s);
    const auto sum = [&](V p, V o, V w) HWY_ATTR {
        return hn::Mul(hn::Add(hn::Add(hn::Mul(a, p), hn::Mul(b, o)), hn::Mul(c, w)), parent_radius);
    };
    return {sum(frame.t1.x, frame.t2.x, frame.n.x), sum(frame.t1.y, frame.t2.y, frame.n.y),
            sum(frame.t1.z, frame.t2.z, frame.n.z)};
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#endif
