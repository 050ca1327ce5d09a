#include "splat/coding/symbol_tables.h"

#include <algorithm>
#include <bit>

#include "core/error.h"

namespace splat {

namespace {

// Weights in steps of a fourth root of two: 5 % off in the mean costs 0.2 % of the bits.
constexpr uint32_t kLevels = 49;
constexpr uint32_t weight_of(uint32_t level) {  // level 1 to kLevels
    constexpr uint32_t kQuarters[4] = {16, 19, 23, 27};
    return kQuarters[(level - 1) % 4] << (level - 1) / 4;
}
constexpr uint32_t kTopWeight = weight_of(kLevels);

constexpr uint32_t kRiceBits = 2;
constexpr uint32_t kMaxQuotient = (2 * kLevels) >> kRiceBits;

class BitWriter {
  public:
    void put(uint32_t value, uint32_t bits) {
        for (uint32_t i = 0; i < bits; ++i) {
            if (count_ % 8 == 0) bytes.push_back(std::byte{0});
            bytes.back() |= std::byte(uint8_t((value >> i & 1) << count_ % 8));
            ++count_;
        }
    }
    std::vector<std::byte> bytes;

  private:
    size_t count_ = 0;
};

class BitReader {
  public:
    BitReader(std::span<const std::byte> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

    uint32_t take(uint32_t bits) {
        uint32_t value = 0;
        for (uint32_t i = 0; i < bits; ++i) {
            if (at_ / 8 >= bytes_.size()) refuse("cut off");
            value |= (uint32_t(bytes_[at_ / 8]) >> at_ % 8 & 1u) << i;
            ++at_;
        }
        return value;
    }
    void end() {
        if ((at_ + 7) / 8 != bytes_.size()) refuse("longer than tables are");
        while (at_ % 8 != 0)
            if (take(1) != 0) refuse("the last bits are not 0");
    }
    [[noreturn]] void refuse(const char* what) const {
        throw core::Error(name_ + ": symbol tables: " + what);
    }

  private:
    std::span<const std::byte> bytes_;
    const std::string& name_;
    size_t at_ = 0;
};

using Levels = std::array<uint32_t, kSymbolCount>;  // 0: never met

uint32_t level_of(uint64_t count, uint64_t most) {
    if (count == 0) return 0;
    const uint64_t weight = uint64_t(double(count) / double(most) * kTopWeight);
    uint32_t level = 1;
    while (level < kLevels && 2 * weight > weight_of(level) + weight_of(level + 1)) ++level;
    return level;
}

void put_levels(const Levels& levels, uint32_t symbols, BitWriter& out) {
    int32_t last = kLevels;
    for (uint32_t s = 0; s < symbols; ++s) {
        out.put(levels[s] != 0, 1);
        if (levels[s] == 0) continue;
        const int32_t step = int32_t(levels[s]) - last;
        const uint32_t folded = uint32_t(step < 0 ? -2 * step - 1 : 2 * step);
        for (uint32_t q = folded >> kRiceBits; q > 0; --q) out.put(1, 1);
        out.put(0, 1);
        out.put(folded & ((1u << kRiceBits) - 1), kRiceBits);
        last = int32_t(levels[s]);
    }
}

Levels take_levels(uint32_t symbols, BitReader& in) {
    Levels levels{};
    int32_t last = kLevels;
    for (uint32_t s = 0; s < symbols; ++s) {
        if (in.take(1) == 0) continue;
        uint32_t quotient = 0;
        while (in.take(1) != 0)
            if (++quotient > kMaxQuotient) in.refuse("a level is out of range");
        const uint32_t folded = quotient << kRiceBits | in.take(kRiceBits);
        last += folded & 1 ? -int32_t(folded / 2) - 1 : int32_t(folded / 2);
        if (last < 1 || last > int32_t(kLevels)) in.refuse("a level is out of range");
        levels[s] = uint32_t(last);
    }
    return levels;
}

// Shares of `states` states by weight, rounded, at least 1 for what was met; the largest share, the first of
// equal ones, takes what is left, and gives one at a time what is lacking.  A context that was never met is
// symbol 0's.
std::array<uint16_t, kSymbolCount> shares_of(const Levels& levels, uint32_t states) {
    std::array<uint16_t, kSymbolCount> shares{};
    uint32_t total = 0, shared = 0;
    for (const uint32_t level : levels) total += level ? weight_of(level) : 0;
    for (uint32_t s = 0; s < kSymbolCount; ++s) {
        if (levels[s] == 0) continue;
        shares[s] =
            uint16_t(std::max<uint64_t>(1, (uint64_t(weight_of(levels[s])) * states + total / 2) / total));
        shared += shares[s];
    }
    for (; shared > states; --shared) --*std::max_element(shares.begin(), shares.end());
    uint16_t& largest = *std::max_element(shares.begin(), shares.end());
    largest = uint16_t(largest + states - shared);
    return shares;
}

// Calls use(context, state within it, symbol) for all states: each symbol's are spread over its context's.
template <class Use>
void spread_states(const SymbolShares& shares, const Use& use) {
    for (const SymbolField& field : kSymbolFields) {
        const uint32_t states = 1u << field.bits, step = states / 2 + states / 8 + 3;
        for (uint32_t c = field.first_context; c < field.first_context + field.contexts; ++c) {
            uint32_t state = 0;
            for (uint32_t s = 0; s < kSymbolCount; ++s)
                for (uint32_t k = 0; k < shares[c][s]; ++k, state = (state + step) % states)
                    use(field, c, state, s);
        }
    }
}

// From the state with that number, as DecodingTables has it.
uint32_t way_on(uint32_t number, const SymbolField& field) {
    const uint32_t bits = field.bits + 1 - uint32_t(std::bit_width(number));
    return 2 * ((number << bits) - (1u << field.bits)) | 1u << bits;
}

uint32_t first_state_of(const SymbolField& field, uint32_t context) {
    return field.first_state + ((context - field.first_context) << field.bits);
}

}  // namespace

std::vector<std::byte> encode_tables(const SymbolCounts& counts, uint32_t kinds) {
    BitWriter out;
    for (const SymbolField& field : std::span(kSymbolFields).first(kinds)) {
        for (uint32_t c = field.first_context; c < field.first_context + field.contexts; ++c) {
            const uint64_t* of = &counts[size_t(c) * kSymbolCount];
            const uint64_t most = *std::max_element(of, of + kSymbolCount);
            out.put(most != 0, 1);
            if (most == 0) continue;
            Levels levels{};
            for (uint32_t s = 0; s < field.symbols; ++s) levels[s] = level_of(of[s], most);
            put_levels(levels, field.symbols, out);
        }
    }
    return std::move(out.bytes);
}

SymbolShares decode_tables(std::span<const std::byte> bytes, uint32_t kinds, const std::string& name) {
    SymbolShares shares;
    BitReader in(bytes, name);
    for (uint32_t kind = 0; kind < kSymbolKinds; ++kind) {
        const SymbolField& field = kSymbolFields[kind];
        for (uint32_t c = field.first_context; c < field.first_context + field.contexts; ++c) {
            Levels levels{};
            if (kind < kinds && in.take(1) != 0) levels = take_levels(field.symbols, in);
            shares[c] = shares_of(levels, 1u << field.bits);
        }
    }
    in.end();
    return shares;
}

std::vector<double> bits_of(const SymbolCounts& counts, const SymbolShares& shares) {
    std::vector<double> bits(counts.end() - kSymbolKinds, counts.end());
    for (uint32_t kind = 0; kind < kSymbolKinds; ++kind) {
        const SymbolField& field = kSymbolFields[kind];
        for (uint32_t c = field.first_context; c < field.first_context + field.contexts; ++c)
            for (uint32_t s = 0; s < kSymbolCount; ++s)
                if (const uint64_t count = counts[size_t(c) * kSymbolCount + s]; count > 0)
                    bits[kind] += double(count) * bits_of_share(shares[c][s], field);
    }
    return bits;
}

DecodingTables::DecodingTables(const SymbolShares& shares) {
    // A symbol's states in ascending order are numbered from its share up, and go on with as many bits as
    // make the number one of 2^field.bits to below twice that.
    std::vector<uint8_t> symbols(kStateCount);
    spread_states(shares, [&](const SymbolField& field, uint32_t c, uint32_t state, uint32_t s) {
        symbols[first_state_of(field, c) + state] = uint8_t(s);
    });
    for (const SymbolField& field : kSymbolFields)
        for (uint32_t c = field.first_context; c < field.first_context + field.contexts; ++c) {
            auto next = shares[c];
            const uint32_t begin = first_state_of(field, c);
            for (uint32_t i = begin; i < begin + (1u << field.bits); ++i)
                states[i] = uint16_t(symbols[i] | way_on(next[symbols[i]]++, field) << 5);
        }
}

EncodingTables::EncodingTables(const SymbolShares& from) : shares(from) {
    const DecodingTables decoding(from);
    for (const SymbolField& field : kSymbolFields)
        for (uint32_t c = field.first_context; c < field.first_context + field.contexts; ++c) {
            uint16_t start = 0;
            for (uint32_t s = 0; s < kSymbolCount; ++s) {
                first[c][s] = start;
                start = uint16_t(start + shares[c][s]);
            }
            const uint32_t begin = first_state_of(field, c);
            std::array<uint32_t, kSymbolCount> met{};
            for (uint32_t i = 0; i < 1u << field.bits; ++i) {
                const uint32_t symbol = decoding.states[begin + i] & (kSymbolCount - 1);
                states[begin + first[c][symbol] + met[symbol]++] = uint16_t(i);
            }
        }
}

}  // namespace splat
