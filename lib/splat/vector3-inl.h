// Three vectors as the coordinates of points, a lane a point.  Included once for each SIMD target, by sources
// that use Highway's foreach_target.h.
#if defined(QS_SPLAT_VECTOR3_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QS_SPLAT_VECTOR3_INL_H
#undef QS_SPLAT_VECTOR3_INL_H
#else
#define QS_SPLAT_VECTOR3_INL_H
#endif

#include <hwy/highway.h>

#include <glm/glm.hpp>

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class V>
struct Vector3 {
    V x, y, z;
};
template <class V>
HWY_INLINE V Dot(const Vector3<V>& a, const Vector3<V>& b) {
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class D, class V = hn::Vec<D>>
HWY_INLINE Vector3<V> Set3(D d, const glm::vec3& v) {
    return {hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z)};
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#endif
