// Decodes the symbols of a compressed block: the coder, as symbol_coder.h has it, that finds them.
//
// Included once for each SIMD target, by sources that use Highway's foreach_target.h: shifts by any number
// are half as fast without the instructions that newer processors have for them.
#if defined(QS_SPLAT_SYMBOL_DECODER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QS_SPLAT_SYMBOL_DECODER_INL_H
#undef QS_SPLAT_SYMBOL_DECODER_INL_H
#else
#define QS_SPLAT_SYMBOL_DECODER_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <cstring>
#include <span>

#include "splat/coding/symbol_tables.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {

// The states of a block that is being decoded, and its bits.  kMeasures: adds to field_bits, by kind, what
// symbols take.
template <class Lanes, bool kMeasures>
class SymbolDecoder {
  public:
    // More than is taken between two begin(), and read at once.
    static constexpr uint64_t kReadAhead = 24;

    // `tail` of 2 kReadAhead bytes, of zeros.
    HWY_INLINE SymbolDecoder(const DecodingTables& tables, std::span<const std::byte> bits, std::byte* tail,
                             double* field_bits)
        : tables_(tables.states.data()),
          bits_(bits.data()),
          size_(bits.size()),
          tail_(tail),
          field_bits_(field_bits) {
        static_cast<void>(begin());
        for (uint32_t lane = 0; lane < Lanes::kCount; ++lane)
            states_[lane] = uint32_t(take(Lanes::kBits[lane]));
    }

    // At least 56 bits are there then.  From where they are read is known since the last time, so that no
    // symbol waits for the memory; what is known of the byte that is not whole yet is or-ed with itself.
    // (Giesen.  Reading bits in far too many ways.  2018, part 2, variant 4.)
    //
    // The last bytes are read from a copy with room behind it, so that nobody need look for the end.
    HWY_INLINE bool begin() {
        if (HWY_UNLIKELY(byte_ + kReadAhead > size_)) {
            if (byte_ > size_ + count_ / 8) return ahead_ = 0, false;
            if (tail_ != nullptr) {
                if (byte_ < size_) std::memcpy(tail_, bits_ + byte_, size_ - byte_);
                bits_ = tail_ - byte_, tail_ = nullptr;
            }
        }
        uint64_t word;
        std::memcpy(&word, bits_ + byte_, sizeof(word));
        ahead_ |= word << count_;
        byte_ += (63 - count_) >> 3;
        count_ |= 56;
        return true;
    }

    template <int kLane, SymbolKind kKind>
    HWY_INLINE uint32_t code(uint32_t context, uint32_t) {
        constexpr SymbolField kField = kSymbolFields[kKind];
        static_assert(kField.bits == Lanes::kBits[kLane]);
        const uint32_t entry = tables_[kField.first_state + (context << kField.bits) + states_[kLane]];
        const uint32_t next = entry >> 5;
        const uint32_t bits = uint32_t(std::countr_zero(next));
        if (kMeasures) field_bits_[kKind] += bits;
        states_[kLane] = ((next & (next - 1)) >> 1) + uint32_t(take(bits));
        return entry & (kSymbolCount - 1);
    }

    template <SymbolKind kKind>
    HWY_INLINE uint64_t plain(uint32_t bits, uint64_t) {
        if (kMeasures) field_bits_[kKind] += bits;
        return take(bits);
    }

    // Whether all bits were taken but for what fills the last byte, and the states are those that encoders
    // begin with.
    HWY_INLINE bool is_at_end() const {
        uint32_t any = 0;
        for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) any |= states_[lane];
        return any == 0 && byte_ - count_ / 8 == size_;
    }

  private:
    HWY_INLINE uint64_t take(uint32_t bits) {
        const uint64_t value = ahead_ & ((uint64_t(1) << bits) - 1);
        ahead_ >>= bits;
        count_ -= bits;
        return value;
    }

    uint32_t states_[Lanes::kCount];
    uint64_t ahead_ = 0, byte_ = 0;  // bits that were read but not taken, and the byte that follows them
    uint32_t count_ = 0;             // of these bits, below 64
    const uint16_t* tables_;
    const std::byte* bits_;
    uint64_t size_;    // in bytes
    std::byte* tail_;  // null once it is read
    double* field_bits_;
};

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#endif
