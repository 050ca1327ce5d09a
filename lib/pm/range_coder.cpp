#include "pm/range_coder.h"

#include <utility>

namespace pm {

void RangeEncoder::shift() {
    if (uint32_t(low_) < 0xff000000u || (low_ >> 32) != 0) {
        const uint8_t carry = uint8_t(low_ >> 32);
        // Before the first byte nothing is kept yet.
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
    std::vector<std::byte> bytes = std::move(bytes_);
    while (!bytes.empty() && bytes.back() == std::byte{0}) bytes.pop_back();
    *this = RangeEncoder();
    return bytes;
}

}  // namespace pm
