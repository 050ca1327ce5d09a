#include "ppve/byte_planes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ppve/byte_planes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ppve::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

uint32_t any_bits(const uint32_t* numbers, size_t count) {
    const hn::ScalableTag<uint32_t> d;
    const size_t lanes = hn::Lanes(d);
    auto any = hn::Zero(d);
    size_t i = 0;
    for (; i + lanes <= count; i += lanes) any = hn::Or(any, hn::LoadU(d, numbers + i));
    alignas(64) uint32_t each[hn::MaxLanes(d)];
    hn::Store(any, d, each);
    uint32_t bits = 0;
    for (size_t k = 0; k < lanes; ++k) bits |= each[k];
    for (; i < count; ++i) bits |= numbers[i];
    return bits;
}

void bytes_of(const uint32_t* numbers, size_t count, int shift, uint8_t* plane) {
    const hn::ScalableTag<uint32_t> d;
    const hn::Rebind<uint8_t, decltype(d)> d8;
    const size_t lanes = hn::Lanes(d);
    const auto low = hn::Set(d, 0xffu);
    size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
        const auto byte = hn::And(hn::ShiftRightSame(hn::LoadU(d, numbers + i), shift), low);
        hn::StoreU(hn::U8FromU32(byte), d8, plane + i);
    }
    for (; i < count; ++i) plane[i] = uint8_t(numbers[i] >> shift);
}

}  // namespace ppve::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ppve {

namespace {
HWY_EXPORT(any_bits);
HWY_EXPORT(bytes_of);
}  // namespace

uint32_t bits_of_any(std::span<const uint32_t> numbers) {
    return HWY_DYNAMIC_DISPATCH(any_bits)(numbers.data(), numbers.size());
}

void take_byte(std::span<const uint32_t> numbers, int byte, uint8_t* plane) {
    HWY_DYNAMIC_DISPATCH(bytes_of)(numbers.data(), numbers.size(), 8 * byte, plane);
}

}  // namespace ppve

#endif
