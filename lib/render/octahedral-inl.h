// Unit normals in 32 bits: two coordinates on an unfolded octahedron, 16 bits each.  A normal comes back
// within 7e-5 radians, a fiftieth of a level of grey. (Highway per-target header: included once for each
// instruction set.)
//
// Cigolle and others.  A survey of efficient representations for independent unit vectors.  2014.
#if defined(RENDER_OCTAHEDRAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RENDER_OCTAHEDRAL_INL_H_
#undef RENDER_OCTAHEDRAL_INL_H_
#else
#define RENDER_OCTAHEDRAL_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float kOctahedralSteps = 32767;

// Anything is a code, what is no normal too.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Vec<hn::RebindToUnsigned<D>> octahedral_codes(D d, V x, V y, V z) {
    const hn::RebindToUnsigned<D> du;
    const V one = hn::Set(d, 1.0f);
    const V length = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
    const V inverse = hn::Div(one, hn::Max(length, hn::Set(d, 1.0e-30f)));
    const V u = hn::Mul(x, inverse), v = hn::Mul(y, inverse);
    const auto below = hn::Lt(z, hn::Zero(d));
    const V folded_u = hn::IfThenElse(below, hn::CopySign(hn::Sub(one, hn::Abs(v)), u), u);
    const V folded_v = hn::IfThenElse(below, hn::CopySign(hn::Sub(one, hn::Abs(u)), v), v);
    const auto code = [&](V coordinate) HWY_ATTR {
        const V steps = hn::Mul(coordinate, hn::Set(d, kOctahedralSteps));
        const V nearest = hn::Floor(hn::Add(steps, hn::Set(d, 0.5f)));
        const V most = hn::Set(d, kOctahedralSteps);
        const hn::RebindToSigned<D> di;
        return hn::BitCast(du, hn::ConvertTo(di, hn::Clamp(nearest, hn::Neg(most), most)));
    };
    return hn::Or(hn::And(code(folded_u), hn::Set(du, 0xffffu)), hn::ShiftLeft<16>(code(folded_v)));
}

template <class V>
struct Normals {
    V x, y, z;
};

template <class D, class VU, class V = hn::Vec<D>>
HWY_INLINE Normals<V> octahedral_normals(D d, VU codes) {
    const hn::RebindToSigned<D> di;
    const V step = hn::Set(d, 1 / kOctahedralSteps);
    const auto both = hn::BitCast(di, codes);
    const V u = hn::Mul(hn::ConvertTo(d, hn::ShiftRight<16>(hn::ShiftLeft<16>(both))), step);
    const V v = hn::Mul(hn::ConvertTo(d, hn::ShiftRight<16>(both)), step);
    const V z = hn::Sub(hn::Sub(hn::Set(d, 1.0f), hn::Abs(u)), hn::Abs(v));
    const V fold = hn::Max(hn::Neg(z), hn::Zero(d));
    const V x = hn::Sub(u, hn::CopySign(fold, u)), y = hn::Sub(v, hn::CopySign(fold, v));
    const V squares = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    const V inverse = hn::Div(hn::Set(d, 1.0f), hn::Sqrt(squares));
    return {hn::Mul(x, inverse), hn::Mul(y, inverse), hn::Mul(z, inverse)};
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
