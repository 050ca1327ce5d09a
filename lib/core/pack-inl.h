// The lanes of a mask moved to the front, of several vectors by one mask.  Included once for each SIMD
// target, by sources that use Highway's foreach_target.h.
//
// Not hn::CompressStore(): to memory, processors with AVX-512 compress by microcode, some of them a hundred
// times slower than in a register.  Whoever stores what of() gives stores whole vectors, and has room for
// them.
#if defined(QS_CORE_PACK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QS_CORE_PACK_INL_H
#undef QS_CORE_PACK_INL_H
#else
#define QS_CORE_PACK_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace core {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Pack {
  public:
    HWY_INLINE explicit Pack(hn::Mask<D> mask) : mask_(mask) {}
    // What follows the lanes of the mask is any lane.
    HWY_INLINE hn::Vec<D> of(hn::Vec<D> v) const { return hn::Compress(v, mask_); }
    HWY_INLINE size_t count() const { return hn::CountTrue(D(), mask_); }

  private:
    hn::Mask<D> mask_;
};

#if HWY_TARGET == HWY_AVX2

// Highway 1.0's Compress() copies its table of 1 KiB to the stack, for every vector.
struct LanesOfBits {
    uint8_t lane[256][8];
    constexpr LanesOfBits() : lane() {
        for (size_t bits = 0; bits < 256; ++bits)
            for (size_t k = 0, to = 0; k < 8; ++k)
                if (bits >> k & 1) lane[bits][to++] = uint8_t(k);
    }
};
inline constexpr LanesOfBits kLanesOfBits;

template <class D>
requires(hn::MaxLanes(D()) == 8 && sizeof(hn::TFromD<D>) == 4) class Pack<D> {
  public:
    HWY_INLINE explicit Pack(hn::Mask<D> mask) {
        uint8_t bits[8];
        hn::StoreMaskBits(D(), mask, bits);
        const hn::Rebind<int32_t, D> di;
        const hn::Rebind<uint8_t, D> du8;
        const auto lanes = hn::PromoteTo(di, hn::LoadU(du8, kLanesOfBits.lane[bits[0]]));
        from_ = hn::IndicesFromVec(D(), lanes);
        count_ = hwy::PopCount(uint64_t(bits[0]));
    }
    HWY_INLINE hn::Vec<D> of(hn::Vec<D> v) const { return hn::TableLookupLanes(v, from_); }
    HWY_INLINE size_t count() const { return count_; }

  private:
    decltype(hn::IndicesFromVec(D(), hn::Zero(hn::Rebind<int32_t, D>()))) from_;
    size_t count_;
};

#endif

}  // namespace HWY_NAMESPACE
}  // namespace core
HWY_AFTER_NAMESPACE();

#endif
