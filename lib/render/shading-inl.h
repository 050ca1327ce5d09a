// shading.h for vectors: the same operations in the same order, hence the same bytes.
// (Highway per-target header: included once for each instruction set.)
#if defined(RENDER_SHADING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RENDER_SHADING_INL_H_
#undef RENDER_SHADING_INL_H_
#else
#define RENDER_SHADING_INL_H_
#endif

#include <hwy/highway.h>

#include "render/shading.h"

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Vec<hn::RebindToUnsigned<D>> nearest_bytes(D d, V value) {
    const V positive = hn::IfThenElseZero(hn::Gt(value, hn::Zero(d)), value);
    const V clamped = hn::Min(positive, hn::Set(d, 255.0f));
    const auto whole = hn::ConvertTo(hn::RebindToSigned<D>(), hn::Add(clamped, hn::Set(d, 0.5f)));
    return hn::BitCast(hn::RebindToUnsigned<D>(), whole);
}

template <class V>
struct Rgb {
    V r, g, b;
};

// 0x00BBGGRR.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Vec<hn::RebindToUnsigned<D>> pack_rgb(D d, V r, V g, V b) {
    return hn::Or(nearest_bytes(d, r),
                  hn::Or(hn::ShiftLeft<8>(nearest_bytes(d, g)), hn::ShiftLeft<16>(nearest_bytes(d, b))));
}

template <class D, class VU>
HWY_INLINE Rgb<hn::Vec<D>> unpack_rgb(D d, VU packed) {
    const hn::RebindToSigned<D> di;
    const hn::RebindToUnsigned<D> du;
    const auto byte = hn::Set(du, 255u);
    return {hn::ConvertTo(d, hn::BitCast(di, hn::And(packed, byte))),
            hn::ConvertTo(d, hn::BitCast(di, hn::And(hn::ShiftRight<8>(packed), byte))),
            hn::ConvertTo(d, hn::BitCast(di, hn::And(hn::ShiftRight<16>(packed), byte)))};
}

// shade_point() of a unit normal and a material.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Vec<hn::RebindToUnsigned<D>> shade_points(D d, Shade shade, const Light& light, V nx, V ny,
                                                         V nz, Rgb<V> material) {
    if (shade == Shade::normal) {
        const V half = hn::Set(d, 127.5f);
        return pack_rgb(d, hn::Add(half, hn::Mul(half, nx)), hn::Sub(half, hn::Mul(half, ny)),
                        hn::Sub(half, hn::Mul(half, nz)));
    }
    if (shade == Shade::flat) return pack_rgb(d, material.r, material.g, material.b);
    const V towards_eye = hn::IfThenElseZero(hn::Lt(nz, hn::Zero(d)), hn::Neg(nz));
    V factor = hn::Add(hn::Set(d, light.ambient), hn::Mul(hn::Set(d, light.head), towards_eye));
    if (light.key > 0.0f) {
        const glm::vec3& l = light.towards_key;
        const V towards_key = hn::Add(hn::Add(hn::Mul(nx, hn::Set(d, l.x)), hn::Mul(ny, hn::Set(d, l.y))),
                                      hn::Mul(nz, hn::Set(d, l.z)));
        factor = hn::Add(factor, hn::Mul(hn::Set(d, light.key), hn::Max(towards_key, hn::Zero(d))));
    }
    return pack_rgb(d, hn::Mul(material.r, factor), hn::Mul(material.g, factor), hn::Mul(material.b, factor));
}

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
