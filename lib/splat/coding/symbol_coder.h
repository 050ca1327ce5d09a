// What goes through the symbols of a block to be compressed: counts them, or codes them.  A model of symbols
// (block_symbols-inl.h, run_symbols-inl.h) asks a coder for code<lane, kind>(context, symbol), which returns
// the symbol, and plain<kind>(bits, value), which returns the value; a decoder (symbol_decoder-inl.h) finds
// both, and does not look at what it is given.  begin() stands before what is at most 56 bits, and is false
// where there are no more.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "splat/coding/symbol_tables.h"

namespace splat {

// Returns what it is given, and takes no note.
struct SymbolReader {
    static bool begin() { return true; }
    template <SymbolKind>
    static uint64_t plain(uint32_t, uint64_t value) {
        return value;
    }
    template <int kLane, SymbolKind kKind>
    static uint32_t code(uint32_t, uint32_t symbol) {
        return symbol;
    }
};

class SymbolCounter {
  public:
    explicit SymbolCounter(SymbolCounts& counts) : counts_(counts) {}
    static bool begin() { return true; }
    template <SymbolKind kKind>
    uint64_t plain(uint32_t bits, uint64_t value) {
        counts_[size_t(kContextCount) * kSymbolCount + kKind] += bits;
        return value;
    }
    template <int kLane, SymbolKind kKind>
    uint32_t code(uint32_t context, uint32_t symbol) {
        ++counts_[size_t(kSymbolFields[kKind].first_context + context) * kSymbolCount + symbol];
        return symbol;
    }

  private:
    SymbolCounts& counts_;
};

// Notes the symbols, and codes them from the last to the first: a decoder takes them the other way.
// Lanes::kBits: of the state of each lane.
template <class Lanes>
class SymbolEncoder {
  public:
    explicit SymbolEncoder(const EncodingTables& tables) : tables_(tables) {}
    static bool begin() { return true; }
    template <SymbolKind>
    uint64_t plain(uint32_t bits, uint64_t value) {
        steps_.push_back({kPlain, 0, uint8_t(bits), value});
        return value;
    }
    template <int kLane, SymbolKind kKind>
    uint32_t code(uint32_t context, uint32_t symbol) {
        steps_.push_back({kKind, kLane, uint8_t(context), symbol});
        return symbol;
    }

    void finish(std::vector<std::byte>& out) {
        std::vector<Bits> bits;  // the last first
        uint32_t states[Lanes::kCount] = {};
        for (size_t i = steps_.size(); i-- > 0;) bits.push_back(step(steps_[i], states[steps_[i].lane]));
        for (uint32_t lane = Lanes::kCount; lane-- > 0;) bits.push_back({states[lane], Lanes::kBits[lane]});
        uint64_t pending = 0;
        uint32_t count = 0;
        for (size_t i = bits.size(); i-- > 0;) {
            pending |= uint64_t(bits[i].value) << count;
            for (count += bits[i].count; count >= 8; count -= 8, pending >>= 8)
                out.push_back(std::byte(uint8_t(pending)));
        }
        if (count > 0) out.push_back(std::byte(uint8_t(pending)));
    }

  private:
    static constexpr uint8_t kPlain = kSymbolKinds;  // no symbol, but so many bits as they are
    struct Step {
        uint8_t kind, lane, context;
        uint64_t symbol;
    };
    struct Bits {
        uint64_t value;
        uint32_t count;
    };

    // Goes from the state after a symbol to that before it; returns the bits that lead back.
    Bits step(const Step& at, uint32_t& state) const {
        if (at.kind == kPlain) return {at.symbol, at.context};
        const SymbolField& field = kSymbolFields[at.kind];
        const uint32_t context = field.first_context + at.context, share = tables_.shares[context][at.symbol];
        const uint32_t from = state + (1u << field.bits);
        uint32_t count = 0;
        while (from >> count >= 2 * share) ++count;
        const uint32_t first =
            field.first_state + (uint32_t(at.context) << field.bits) + tables_.first[context][at.symbol];
        state = tables_.states[first + (from >> count) - share];
        return {from & ((1u << count) - 1), count};
    }

    const EncodingTables& tables_;
    std::vector<Step> steps_;
};

// Numbers before a block's bits: 7 bits a byte, the lowest first; the high bit says that more follow.
inline void put_number(uint64_t value, std::vector<std::byte>& out) {
    for (; value >= 128; value >>= 7) out.push_back(std::byte(uint8_t(value | 128)));
    out.push_back(std::byte(uint8_t(value)));
}
inline bool take_number(std::span<const std::byte>& bytes, uint64_t& value) {
    value = 0;
    for (uint32_t shift = 0; shift < 63; shift += 7) {
        if (bytes.empty()) return false;
        const uint64_t byte = uint64_t(bytes[0]);
        bytes = bytes.subspan(1);
        value |= (byte & 127) << shift;
        if (byte < 128) return true;
    }
    return false;
}

}  // namespace splat
