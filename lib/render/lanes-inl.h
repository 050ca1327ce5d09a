// Lanes of whole vectors: their numbers, their values in double, pixels in pairs, masks as bits.
// (Highway per-target header: included once for each instruction set.)
#if defined(RENDER_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef RENDER_LANES_INL_H_
#undef RENDER_LANES_INL_H_
#else
#define RENDER_LANES_INL_H_
#endif

#include <hwy/highway.h>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace render::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::ScalableTag<float>;
using V = hn::Vec<F>;
using U = hn::RebindToUnsigned<F>;
constexpr size_t kMaxLanes = hn::MaxLanes(F());

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

HWY_INLINE hn::Vec<U> pack_pixels(V x, V y) {
    const hn::RebindToSigned<F> di;
    const auto xi = hn::BitCast(U(), hn::ConvertTo(di, x));
    const auto yi = hn::BitCast(U(), hn::ConvertTo(di, y));
    return hn::Or(xi, hn::ShiftLeft<16>(yi));
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

}  // namespace render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
