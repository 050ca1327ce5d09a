// Mutations of inputs, the same for the same seed: what replays and searches of fuzz targets try.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace fuzz {

using Bytes = std::vector<uint8_t>;

// Flips bits, sets bytes and words to values that parsers trip over, or cuts the end off: near the input.
Bytes mutated(Bytes bytes, std::mt19937_64& random);

// Further away: also repeats, removes and inserts runs of bytes, some of them from `other`.  Of at most
// max(`limit`, size of `bytes`) bytes.
Bytes mutated_further(Bytes bytes, const Bytes& other, size_t limit, std::mt19937_64& random);

}  // namespace fuzz
