// One block of a compressed model: coded by itself, decoded to the bytes of the plain block.
//
// Six interleaved state machines (tabled asymmetric numeral systems), to which the fields of a node fall,
// share one sequence of bits, so that a processor can have several symbols under way at once.  man/qs.5
// specifies the bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "splat/coding/symbol_tables.h"
#include "splat/format.h"

namespace splat {

// What a coded block takes at least: two numbers of a byte, slot, checksum, six states of 51 bits.
constexpr size_t kMinCodedBlock = 15;

// A block as it stands in the file, and the sizes of its sibling groups in order, which only its parents
// know.
struct PlainBlock {
    uint64_t number;
    std::span<const std::byte> bytes;
    std::span<const uint8_t> groups;  // each 1 to kMaxFanOut
};

class BlockCodec {
  public:
    explicit BlockCodec(const Header& header) : layout_(header), has_colour_(header.has_colour()) {}

    // True where the block holds nodes as builders write them, in such groups: only then it can be counted
    // and coded. What is behind its nodes is not looked at, and does not come back.
    bool can_code(const PlainBlock& block) const;

    void count(const PlainBlock& block, SymbolCounts& counts) const;

    std::vector<std::byte> encode(const PlainBlock& block, const EncodingTables& tables) const;

    // Fills `block`, whose bytes were 0 or are from a decoding of the same bytes.  False where `coded` is
    // damaged; whether it is as it was written, the plain block's checksum tells.  Any bytes are safe.
    bool decode(uint64_t number, std::span<const std::byte> coded, const DecodingTables& tables,
                std::span<std::byte> block) const;

    // Adds to bits[i] what field i of kSymbolFields takes in a coded block.  As decode().
    bool measure(std::span<const std::byte> coded, const DecodingTables& tables,
                 std::span<double> bits) const;

  private:
    BlockLayout layout_;
    bool has_colour_;
};

}  // namespace splat
