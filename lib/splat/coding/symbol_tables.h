// How likely each symbol of a compressed block is, in each context: the static tables of a compressed model,
// and the state machines that code by them.
//
// A table is trained on the model it goes with and stands, coarsened, in the file.  Encoder and decoder work
// from what stands there.  man/qs.5 specifies the numbers.
//
// Duda.  Asymmetric numeral systems.  2013 (the tabled variant; states are spread as by Collet's FSE).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace splat {

constexpr uint32_t kSymbolCount = 32;  // in each context; many use fewer

enum SymbolKind : uint32_t {
    kGroupSize,
    kShape,
    kAttitude,
    kRadiusCode,
    kNormal,
    kAlong,
    kGreen,
    kRed,
    kBlue,
    kGreenBit,
    kNodeSymbolKinds,  // so far those of nodes; what follows is of runs of triangles
    kGlue = kNodeSymbolKinds,
    kEntry,
    kPositionClass,
    kPosition,
    kNormalClass,
    kCornerNormal,
    kSymbolKinds
};

// One of the fields that a node, or a run of triangles, is taken apart into.
struct SymbolField {
    const char* channel;  // under which qs-info tells what it takes
    uint32_t contexts, symbols;
    uint32_t bits;                                // a context's table has 2^bits states
    uint32_t first_context = 0, first_state = 0;  // in all of the tables
};

// Contexts and states were chosen so that all tables, with two bytes a state, fit into 64 KiB.
inline constexpr std::array<SymbolField, kSymbolKinds> kSymbolFields = [] {
    std::array<SymbolField, kSymbolKinds> fields{{{"structure_and_cone", 1, 7, 8},
                                                  {"flatness_and_error", 16, 32, 9},
                                                  {"structure_and_cone", 8, 32, 9},
                                                  {"sphere", 9, 16, 8},
                                                  {"normal", 17, 31, 8},
                                                  {"sphere", 6, 32, 9},
                                                  {"colour", 2, 32, 8},
                                                  {"colour", 2, 32, 8},
                                                  {"colour", 1, 32, 8},
                                                  {"colour", 2, 2, 8},
                                                  {"triangles", 2, 31, 8},
                                                  {"triangles", 2, 23, 8},
                                                  {"triangles", 4, 4, 6},
                                                  {"triangles", 5, 32, 8},
                                                  {"triangles", 4, 4, 6},
                                                  {"triangles", 3, 32, 8}}};
    for (size_t f = 1; f < fields.size(); ++f) {
        const SymbolField& before = fields[f - 1];
        fields[f].first_context = before.first_context + before.contexts;
        fields[f].first_state = before.first_state + (before.contexts << before.bits);
    }
    return fields;
}();
constexpr uint32_t kContextCount = kSymbolFields.back().first_context + kSymbolFields.back().contexts;
constexpr uint32_t kStateCount =
    kSymbolFields.back().first_state + (kSymbolFields.back().contexts << kSymbolFields.back().bits);
static_assert(kStateCount * sizeof(uint16_t) <= 65536);

// How often each symbol was met, context by context; then, by kind, bits that went along as they are.
using SymbolCounts = std::vector<uint64_t>;
inline SymbolCounts no_symbols() {
    return SymbolCounts(size_t(kContextCount) * kSymbolCount + kSymbolKinds);
}

// How many of its context's states each symbol has.
using SymbolShares = std::array<std::array<uint16_t, kSymbolCount>, kContextCount>;

constexpr size_t kMaxTableBytes = 16384;  // more than any tables take

// Of the first `kinds`: kNodeSymbolKinds or kSymbolKinds.
std::vector<std::byte> encode_tables(const SymbolCounts& counts, uint32_t kinds);
// Symbols of the other kinds are 0 always.  Throws core::Error "<name>: symbol tables: ..." where the bytes
// are no tables, or more than tables.
SymbolShares decode_tables(std::span<const std::byte> bytes, uint32_t kinds, const std::string& name);

// How many bits these take, by field.
std::vector<double> bits_of(const SymbolCounts& counts, const SymbolShares& shares);
inline double bits_of_share(uint32_t share, const SymbolField& field) {
    return field.bits - std::log2(double(share));
}

// Decoding: the symbol of each state, and << 5 how to go on: twice the next state without the low bits that
// are to be read, and in the place of these a single 1, as high as they are many.  (A number of bits would
// not fit beside the rest into two bytes; to count zeros from below is fast everywhere, from above it is
// not.)
struct DecodingTables {
    explicit DecodingTables(const SymbolShares& shares);
    std::array<uint16_t, kStateCount> states;
};

// Encoding: a context's states by symbol, each symbol's in ascending order.
struct EncodingTables {
    explicit EncodingTables(const SymbolShares& from);
    const SymbolShares& shares;
    std::array<uint16_t, kStateCount> states;
    std::array<std::array<uint16_t, kSymbolCount>, kContextCount> first;  // of a symbol, within its context
};

}  // namespace splat
