// LZW as in compress(1): codes of 9 to 16 bits, least bit first, the dictionary emptied when it is full.
//
// Welch.  A technique for high-performance data compression.  1984.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace ppve {

std::vector<std::byte> lzw_encode(std::span<const std::byte> bytes);

// Fills `out` to its end.  Throws core::Error where the codes are not those of so many bytes.
void lzw_decode(std::span<const std::byte> codes, std::span<std::byte> out);

}  // namespace ppve
