#include "pm/range_coder.h"

namespace pm {

void RangeEncoder::shift() {
    if (uint32_t(low_) < 0xff000000u || (low_ >> 32) != 0) {
        const uint8_t carry = uint8_t(low_ >> 32);
        for (uint8_t byte = cache_; pending_ > 0; --pending_, byte = 0xff)
            bytes_.push_back(std::byte(uint8_t(byte + carry)));
        cache_ = uint8_t(low_ >> 24);
        pending_ = 0;
    }
    ++pending_;
    low_ = uint32_t(low_) << 8;
}

std::vector<std::byte> RangeEncoder::finish() {
    // Any number in [low, low + range) will do: that with the most zeros at its end.
    for (int zeros = 32; zeros > 0; --zeros) {
        const uint64_t mask = (uint64_t(1) << zeros) - 1;
        const uint64_t rounded = (low_ + mask) & ~mask;
        if (rounded < low_ + range_) {
            low_ = rounded;
            break;
        }
    }
    for (int i = 0; i != 5; ++i) shift();
    std::vector<std::byte> bytes(bytes_.begin() + 1, bytes_.end());
    // The decoder reads four bytes ahead; so many may be left out, and no more, or a stream that is cut off
    // would look like one that ends in zeros.
    for (int left = 4; left > 0 && !bytes.empty() && bytes.back() == std::byte{0}; --left) bytes.pop_back();
    *this = RangeEncoder();
    return bytes;
}

}  // namespace pm
