// A block's nodes as a sequence of symbols, each in a context that follows from the symbols before it: the
// model of compressed blocks, the same code for counting, encoding and decoding.  man/qs.5 specifies it.
//
// A block is decoded alone, so nothing of its nodes' parents is known but what siblings have in common.  What
// pays: flatness and error of the node before; of siblings, normals, and heights: they lie on one surface,
// which the normals tilt.  Left and right are alike, and so are the two directions across: contexts are
// folded, which halves the tables twice.  What would pay a little more, and was slower, as each symbol waits
// for one before it: normals by places and the bend of the group (0.03 bytes a vertex) and places by those of
// siblings (0.07) by a third, heights by how much they change about here (0.006) by a tenth.
//
// Included once for each SIMD target, by sources that use Highway's foreach_target.h.
#if defined(QS_SPLAT_BLOCK_SYMBOLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QS_SPLAT_BLOCK_SYMBOLS_INL_H
#undef QS_SPLAT_BLOCK_SYMBOLS_INL_H
#else
#define QS_SPLAT_BLOCK_SYMBOLS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>

#include "splat/coding/symbol_tables.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {

// Nodes are coded in runs, a run's fields in turn: places first, then normals, then colours.  So what a loop
// needs fits into registers.
constexpr uint32_t kRunNodes = 64;

// The codes of a run of nodes, field by field: what needs no symbol is done for many at once.
struct RunCodes {
    template <class T>
    using Field = std::array<T, kRunNodes>;
    Field<uint8_t> shape{};     // flatness, error << 2
    Field<uint8_t> attitude{};  // children, cone << 3
    Field<uint8_t> radius{};
    Field<uint8_t> across{};
    Field<int8_t> normal[2]{};  // -15 to 15
    Field<uint8_t> along{};     // 0 to 31
    Field<uint16_t> colour{};
    Field<uint8_t> is_first{};  // of its group
    Field<int8_t> at[2]{};      // of `across`, -5 to 5
};

// Signs as masks, 0 or -1, and sums of them: a branch on a sign would go wrong at every other node.
HWY_INLINE int32_t SignOf(int32_t value) {
    return value >> 31;
}
HWY_INLINE int32_t Mirrored(int32_t value, int32_t sign) {
    return (value ^ sign) - sign;
}

// How much more the surface bends than at the node before, in five classes.  A table: as arithmetic it would
// be the longest of what a symbol waits for.  Damaged blocks have places across up to 127, so one row more
// than there are.
constexpr int32_t kMostBend = 15 * 5 + 15 * 6, kMostBendChange = 2 * kMostBend;
constexpr auto kBendClasses = [] {
    std::array<uint8_t, 2 * size_t(kMostBendChange) + 1> classes{};
    for (int32_t change = -kMostBendChange; change <= kMostBendChange; ++change)
        classes[size_t(change + kMostBendChange)] =
            uint8_t((change > -18) + (change > -6) + (change >= 6) + (change >= 18));
    return classes;
}();

// A coder has code<lane, kind>(context, symbol): it returns the symbol, which a decoder finds and does not
// look at. Each lane is a state of its own, of as many bits as all kinds have that use it.
enum Lane { kShapeLane, kAttitudeLane, kRadiusLane, kNormalLane, kAlongLane = kNormalLane + 2 };

template <int kLane, SymbolKind kKind, class Coder>
HWY_INLINE int32_t CodeSigned(Coder& coder, int32_t context, int32_t value, int32_t limit, int32_t sign) {
    const uint32_t symbol = uint32_t(Mirrored(value, sign) + limit);
    return Mirrored(int32_t(coder.template code<kLane, kKind>(uint32_t(context), symbol)) - limit, sign);
}

// What is known from the nodes before: of any group, or where a symbol depends on is_first, of the same.
struct PlacesBefore {
    uint32_t shape = 0, attitude = 0, radius = 0;
    uint32_t left_in_group = 0;
};
struct NormalsBefore {
    int32_t normal[2] = {0, 0};
    int32_t along = 0;
    int32_t last_bend = 0;
};

// By whether the node before is a leaf, and by its shape.
constexpr auto kShapeContexts = [] {
    std::array<std::array<uint8_t, 32>, 2> contexts{};
    for (uint32_t shape = 0; shape < 32; ++shape) {
        const uint32_t flatness = shape & 3, error = shape >> 2;
        contexts[0][shape] = uint8_t(flatness);
        contexts[1][shape] = uint8_t(4 + 3 * std::min(error, 3u) + std::min(flatness, 2u));
    }
    return contexts;
}();

template <class Coder, class Nodes>
HWY_INLINE void CodePlaces(Coder& coder, Nodes& nodes, PlacesBefore& before, RunCodes& run, uint32_t i) {
    const bool is_first = before.left_in_group == 0;
    if (is_first)
        before.left_in_group = 1 + coder.template code<kRadiusLane, kGroupSize>(0, nodes.group_size() - 1);
    --before.left_in_group;
    const uint32_t after_leaf = (before.attitude & 7) == 0;
    // Both are looked up before it is known which one is wanted.
    const uint32_t if_inner = kShapeContexts[0][before.shape], if_leaf = kShapeContexts[1][before.shape];
    before.shape = coder.template code<kShapeLane, kShape>(after_leaf ? if_leaf : if_inner, run.shape[i]);
    before.attitude = coder.template code<kAttitudeLane, kAttitude>(2 * (before.attitude >> 3) + after_leaf,
                                                                    run.attitude[i]);
    before.radius =
        coder.template code<kRadiusLane, kRadiusCode>(is_first ? 8 : before.radius >> 1, run.radius[i]);
    run.across[i] = uint8_t(coder.template plain<kRadiusCode>(7, run.across[i]));
    run.is_first[i] = is_first;
    run.shape[i] = uint8_t(before.shape), run.attitude[i] = uint8_t(before.attitude);
    run.radius[i] = uint8_t(before.radius);
}

// What normals are held against: where across, from the middle.
HWY_INLINE void FindAcross(RunCodes& run) {
    for (uint32_t i = 0; i < kRunNodes; ++i) {
        const uint16_t row = uint16_t(uint16_t(run.across[i] * 187) >> 11);  // across / 11
        run.at[0][i] = int8_t(run.across[i] - 11 * row - 5);
        run.at[1][i] = int8_t(row - 5);
    }
}

template <int kAxis, class Coder>
HWY_INLINE int32_t CodeNormal(Coder& coder, const NormalsBefore& before, bool is_first, int32_t normal) {
    const int32_t last = before.normal[kAxis];
    const int32_t context = is_first ? 16 : std::abs(last);
    return CodeSigned<kNormalLane + kAxis, kNormal>(coder, context, normal, 15, is_first ? 0 : SignOf(last));
}

// Siblings lie on one surface: a step along the normal goes with how much more the normal leans outwards.
template <class Coder>
HWY_INLINE int32_t CodeAlong(Coder& coder, const NormalsBefore& before, bool is_first, int32_t along,
                             int32_t bend) {
    const uint32_t bend_class = kBendClasses[size_t(bend - before.last_bend + kMostBendChange)];
    const uint32_t context = is_first ? 5 : bend_class;
    const int32_t from = is_first ? 0 : before.along;
    const uint32_t step = uint32_t(along - from) & 31;
    return int32_t(coder.template code<kAlongLane, kAlong>(context, step) + uint32_t(from)) & 31;
}

template <class Coder>
HWY_INLINE void CodeNormals(Coder& coder, NormalsBefore& before, RunCodes& run, uint32_t i) {
    const bool is_first = run.is_first[i] != 0;
    const int32_t u = CodeNormal<0>(coder, before, is_first, run.normal[0][i]);
    const int32_t v = CodeNormal<1>(coder, before, is_first, run.normal[1][i]);
    const int32_t bend = u * run.at[0][i] + v * run.at[1][i];
    const int32_t along = CodeAlong(coder, before, is_first, run.along[i], bend);
    run.normal[0][i] = int8_t(u), run.normal[1][i] = int8_t(v), run.along[i] = uint8_t(along);

    before.last_bend = bend, before.along = along;
    before.normal[0] = u, before.normal[1] = v;
}

struct ColoursBefore {
    uint32_t colour = 0;
    bool has_green_change = false;
};

// Differences to the node before: of green without its last bit, then of red and blue to that of green.
template <class Coder>
HWY_INLINE uint32_t CodeColour(Coder& coder, ColoursBefore& before, uint32_t colour) {
    const uint32_t last = before.colour, last_bit = last >> 5 & 1;
    const auto difference = [](uint32_t a, uint32_t b) { return (a - b) & 31; };
    const uint32_t green = coder.template code<kRadiusLane, kGreen>(uint32_t(before.has_green_change),
                                                                    difference(colour >> 6, last >> 6));
    const uint32_t red = coder.template code<kNormalLane, kRed>(
        uint32_t(green != 0), difference(difference(colour >> 11, last >> 11), green));
    const uint32_t blue =
        coder.template code<kNormalLane + 1, kBlue>(0, difference(difference(colour, last), green));
    const bool is_same = green == 0 && red == 0 && blue == 0;
    const uint32_t bit =
        coder.template code<kRadiusLane, kGreenBit>(uint32_t(is_same), (colour >> 5 & 1) ^ last_bit);
    before.colour = (((last >> 11) + green + red) & 31) << 11 | (((last >> 6) + green) & 31) << 6 |
                    (bit ^ last_bit) << 5 | ((last + green + blue) & 31);
    before.has_green_change = green != 0;
    return before.colour;
}

// Nodes have group_size(), get(first, count, run), put(first, count, run) and put_colours(first, count, run):
// behind `count` a run has anything.  A coder's begin() stands before what is at most 56 bits.  False where
// there is no more input, or the groups are not those of `count` nodes.
template <bool kHasColour, class Coder, class Nodes>
HWY_INLINE bool CodeNodes(Coder& coder, Nodes& nodes, uint32_t count) {
    PlacesBefore places;
    NormalsBefore normals;
    ColoursBefore colours;
    RunCodes run;
    for (uint32_t first = 0; first < count; first += kRunNodes) {
        const uint32_t in_run = std::min(kRunNodes, count - first);
        nodes.get(first, in_run, run);
        for (uint32_t i = 0; i < in_run; ++i) {
            if (!coder.begin()) return false;
            CodePlaces(coder, nodes, places, run, i);
        }
        FindAcross(run);
        for (uint32_t i = 0; i < in_run; ++i) {
            if (!coder.begin()) return false;
            CodeNormals(coder, normals, run, i);
        }
        nodes.put(first, in_run, run);
        for (uint32_t i = 0; kHasColour && i < in_run; ++i) {
            if (!coder.begin()) return false;
            run.colour[i] = uint16_t(CodeColour(coder, colours, run.colour[i]));
        }
        if (kHasColour) nodes.put_colours(first, in_run, run);
    }
    return places.left_in_group == 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#endif
