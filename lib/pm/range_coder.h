// An adaptive binary range coder, and the numbers that packets are made of in it.
//
// Martin.  Range encoding: an algorithm for removing redundancy from a digitised message.  1979; with carries
// propagated as in LZMA.  Encoder and decoder have the same functions, which take a value and give one: the
// encoder what it was given, the decoder what it read.  So what is coded is written down once, for both.
//
// The decoder reads zeros behind the end of its bytes, and gives some value for any bytes whatever.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pm {

// The probability of a 0, learned from what was coded: the mean of a fast and of a slow average.
class BitModel {
  public:
    uint32_t zero() const { return (uint32_t(fast_) + slow_) >> 1; }  // of 65536, never 0 or 65536
    void learn(bool bit) {
        fast_ = uint16_t(bit ? fast_ - (fast_ >> 4) : fast_ + ((0xffff - fast_) >> 4));
        slow_ = uint16_t(bit ? slow_ - (slow_ >> 7) : slow_ + ((0xffff - slow_) >> 7));
    }

  private:
    uint16_t fast_ = 0x8000, slow_ = 0x8000;
};

class RangeEncoder {
  public:
    bool bit(BitModel& model, bool value) {
        const uint32_t bound = (range_ >> 16) * model.zero();
        if (value)
            low_ += bound, range_ -= bound;
        else
            range_ = bound;
        model.learn(value);
        normalise();
        return value;
    }
    // value < count, 1 <= count <= 65536
    uint32_t uniform(uint32_t count, uint32_t value) {
        range_ /= count;
        low_ += uint64_t(range_) * value;
        normalise();
        return value;
    }
    // The bytes, without up to four zeros at their end; the encoder is then as new.
    std::vector<std::byte> finish();
    size_t size() const { return bytes_.size() + pending_ - 1; }  // so far

  private:
    void normalise() {
        while (range_ < (1u << 24)) range_ <<= 8, shift();
    }
    void shift();

    uint64_t low_ = 0;
    uint32_t range_ = 0xffffffff;
    uint8_t cache_ = 0;
    // cache_ and bytes of 255 behind it, to which a carry may come; the first of all is a 0 before the point.
    size_t pending_ = 1;
    std::vector<std::byte> bytes_;
};

class RangeDecoder {
  public:
    explicit RangeDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
        for (int i = 0; i != 4; ++i) code_ = code_ << 8 | next();
    }
    bool bit(BitModel& model, bool = false) {
        const uint32_t bound = (range_ >> 16) * model.zero();
        const bool value = code_ >= bound;
        if (value)
            code_ -= bound, range_ -= bound;
        else
            range_ = bound;
        model.learn(value);
        normalise();
        return value;
    }
    uint32_t uniform(uint32_t count, uint32_t = 0) {
        range_ /= count;
        const uint32_t value = std::min(code_ / range_, count - 1);
        code_ -= range_ * value;
        normalise();
        return value;
    }
    // More has been read than there was: what was read last is made of zeros alone.
    bool is_beyond_end() const { return at_ > bytes_.size() + 8; }

  private:
    void normalise() {
        while (range_ < (1u << 24)) range_ <<= 8, code_ = code_ << 8 | next();
    }
    uint32_t next() {
        const size_t at = at_++;
        return at < bytes_.size() ? uint32_t(bytes_[at]) : 0;
    }

    std::span<const std::byte> bytes_;
    size_t at_ = 0;
    uint32_t code_ = 0, range_ = 0xffffffff;
};

// Numbers from 0 on, small ones most likely: the count of bits by models, then the three highest of them,
// then the rest as it is (Exp-Golomb).  Up to 2^kLengths - 2.
template <size_t kLengths = 32>
struct NumberModel {
    std::array<BitModel, kLengths> length;
    std::array<std::array<BitModel, 7>, kLengths> high;
};

template <size_t kLengths, class Coder>
uint32_t code_number(Coder& coder, NumberModel<kLengths>& model, uint32_t value) {
    const uint64_t plus_one = uint64_t(value) + 1;
    const size_t length_of_value = 63 - size_t(std::countl_zero(plus_one));
    size_t length = 0;
    while (length + 1 < kLengths && coder.bit(model.length[length], length < length_of_value)) ++length;
    uint64_t bits = 1;
    size_t left = length;
    for (size_t node = 0; left > 0 && left + 3 > length; --left) {
        const bool bit = coder.bit(model.high[length][node], plus_one >> (left - 1) & 1);
        bits = bits << 1 | uint64_t(bit);
        node = 2 * node + 1 + size_t(bit);
    }
    while (left > 0) {
        const size_t piece = std::min<size_t>(left, 16);
        left -= piece;
        const uint32_t count = 1u << piece;
        bits = bits << piece | coder.uniform(count, uint32_t(plus_one >> left) & (count - 1));
    }
    return uint32_t(bits - 1);
}

template <size_t kLengths = 32>
struct SignedModel {
    NumberModel<kLengths> magnitude;
    BitModel sign;
};

template <size_t kLengths, class Coder>
int64_t code_signed(Coder& coder, SignedModel<kLengths>& model, int64_t value) {
    const int64_t size = value < 0 ? -value : value;
    const int64_t magnitude = int64_t(code_number(coder, model.magnitude, uint32_t(size)));
    if (magnitude == 0) return 0;
    return coder.bit(model.sign, value < 0) ? -magnitude : magnitude;
}

// Numbers below 2^bits, by a tree of models.
template <size_t kBits>
struct TreeModel {
    std::array<BitModel, size_t{1} << kBits> nodes;
};

template <size_t kBits, class Coder>
uint32_t code_tree(Coder& coder, TreeModel<kBits>& model, uint32_t value) {
    uint32_t node = 1;
    for (size_t bit = kBits; bit-- > 0;)
        node = node << 1 | uint32_t(coder.bit(model.nodes[node], value >> bit & 1));
    return node - (1u << kBits);
}

}  // namespace pm
