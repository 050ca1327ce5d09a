// A block's nodes as a sequence of symbols, each in a context that follows from the symbols before it: the
// model of compressed blocks, the same code for counting, encoding and decoding.  man/qs.5 specifies it.
//
// A block is decoded alone, so nothing of its nodes' parents is known but what siblings have in common.  What
// pays: flatness and error of the node before; of siblings, normals, and heights: they lie on one surface,
// which the normals tilt.  Left and right are alike, and so are the two directions across: contexts are
// folded, which halves the tables twice.  What would pay a little more, and was slower by a third, as each
// symbol waits for one before it: normals by places and the bend of the group (0.03 bytes a vertex), places
// by those of siblings (0.07).
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
#include <bit>
#include <cstdlib>

#include "splat/coding/symbol_tables.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {

// The codes of one node.
struct NodeCodes {
    uint32_t shape = 0;     // flatness, error << 2
    uint32_t attitude = 0;  // children, cone << 3
    uint32_t radius = 0;
    uint32_t across = 60;
    int32_t normal[2] = {0, 0};  // -15 to 15
    int32_t along = 0;           // 0 to 31
    uint32_t colour = 0;
    bool is_first = false;  // of its group
};

// Nodes are coded in runs, a run's fields in turn: places first, then normals, then colours.  So what a loop
// needs fits into registers.
constexpr uint32_t kRunNodes = 64;

// Signs as masks, 0 or -1, and sums of them: a branch on a sign would go wrong at every other node.
HWY_INLINE int32_t SignOf(int32_t value) {
    return value >> 31;
}
HWY_INLINE int32_t Mirrored(int32_t value, int32_t sign) {
    return (value ^ sign) - sign;
}

// 0, 1 or 2 by how many of the thresholds |value| reaches, with its sign.
HWY_INLINE int32_t StepsOf(int32_t value, int32_t first, int32_t second) {
    const int32_t size = std::abs(value);
    return Mirrored(2 + SignOf(size - first) + SignOf(size - second), SignOf(value));
}

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
    int32_t ripple = 64;  // 16 times the mean step along, of siblings
    int32_t last_bend = 0;
};

template <class Coder, class Nodes>
HWY_INLINE void CodePlaces(Coder& coder, Nodes& nodes, PlacesBefore& before, NodeCodes& node) {
    node.is_first = before.left_in_group == 0;
    if (node.is_first)
        before.left_in_group = 1 + coder.template code<kRadiusLane, kGroupSize>(0, nodes.group_size() - 1);
    --before.left_in_group;
    const uint32_t flatness = before.shape & 3, error = before.shape >> 2;
    const uint32_t after_leaf = (before.attitude & 7) == 0;
    const uint32_t context = after_leaf ? 4 + 3 * std::min(error, 3u) + std::min(flatness, 2u) : flatness;
    node.shape = coder.template code<kShapeLane, kShape>(context, node.shape);
    node.attitude =
        coder.template code<kAttitudeLane, kAttitude>(2 * (before.attitude >> 3) + after_leaf, node.attitude);
    node.radius =
        coder.template code<kRadiusLane, kRadiusCode>(node.is_first ? 8 : before.radius >> 1, node.radius);
    node.across = uint32_t(coder.template plain<kRadiusCode>(7, node.across));
    before.shape = node.shape, before.attitude = node.attitude, before.radius = node.radius;
}

template <int kAxis, class Coder>
HWY_INLINE void CodeNormal(Coder& coder, const NormalsBefore& before, NodeCodes& node) {
    const int32_t last = before.normal[kAxis];
    const int32_t context = node.is_first ? 16 : std::abs(last);
    node.normal[kAxis] = CodeSigned<kNormalLane + kAxis, kNormal>(coder, context, node.normal[kAxis], 15,
                                                                  node.is_first ? 0 : SignOf(last));
}

// Siblings lie on one surface: a step along the normal goes with how much more the normal leans outwards.
template <class Coder>
HWY_INLINE void CodeAlong(Coder& coder, const NormalsBefore& before, NodeCodes& node, int32_t bend) {
    const int32_t ripple_class = 2 + SignOf(before.ripple - 32) + SignOf(before.ripple - 64);
    const int32_t context =
        node.is_first ? 15 : 5 * ripple_class + StepsOf(bend - before.last_bend, 6, 18) + 2;
    const int32_t from = node.is_first ? 0 : before.along;
    const uint32_t step = uint32_t(node.along - from) & 31;
    node.along =
        int32_t(coder.template code<kAlongLane, kAlong>(uint32_t(context), step) + uint32_t(from)) & 31;
}

template <class Coder>
HWY_INLINE void CodeNormals(Coder& coder, NormalsBefore& before, NodeCodes& node) {
    CodeNormal<0>(coder, before, node);
    CodeNormal<1>(coder, before, node);
    const int32_t row = int32_t(node.across * 187 >> 11);  // across / 11
    const int32_t bend = node.normal[0] * (int32_t(node.across) - 11 * row - 5) + node.normal[1] * (row - 5);
    CodeAlong(coder, before, node, bend);

    if (!node.is_first) before.ripple += (16 * std::abs(node.along - before.along) - before.ripple) >> 2;
    before.last_bend = bend, before.along = node.along;
    before.normal[0] = node.normal[0], before.normal[1] = node.normal[1];
}

struct ColoursBefore {
    uint32_t colour = 0;
    bool has_green_change = false;
};

// Differences to the node before: of green without its last bit, then of red and blue to that of green.
template <class Coder>
HWY_INLINE void CodeColour(Coder& coder, ColoursBefore& before, NodeCodes& node) {
    const uint32_t last = before.colour, last_bit = last >> 5 & 1;
    const auto difference = [](uint32_t a, uint32_t b) { return (a - b) & 31; };
    const uint32_t green = coder.template code<kRadiusLane, kGreen>(uint32_t(before.has_green_change),
                                                                    difference(node.colour >> 6, last >> 6));
    const uint32_t red = coder.template code<kNormalLane, kRed>(
        uint32_t(green != 0), difference(difference(node.colour >> 11, last >> 11), green));
    const uint32_t blue =
        coder.template code<kNormalLane + 1, kBlue>(0, difference(difference(node.colour, last), green));
    const bool is_same = green == 0 && red == 0 && blue == 0;
    const uint32_t bit =
        coder.template code<kRadiusLane, kGreenBit>(uint32_t(is_same), (node.colour >> 5 & 1) ^ last_bit);
    node.colour = (((last >> 11) + green + red) & 31) << 11 | (((last >> 6) + green) & 31) << 6 |
                  (bit ^ last_bit) << 5 | ((last + green + blue) & 31);
    before.colour = node.colour, before.has_green_change = green != 0;
}

// Nodes have group_size(), get(slot, codes), put(slot, codes) and put_colour(slot, colour).  A coder's
// begin() stands before what is at most 57 bits.  False where there is no more input, or the groups are
// not those of `count` nodes.
template <bool kHasColour, class Coder, class Nodes>
HWY_INLINE bool CodeNodes(Coder& coder, Nodes& nodes, uint32_t count) {
    PlacesBefore places;
    NormalsBefore normals;
    ColoursBefore colours;
    NodeCodes run[kRunNodes];
    for (uint32_t first = 0; first < count; first += kRunNodes) {
        const uint32_t in_run = std::min(kRunNodes, count - first);
        for (uint32_t i = 0; i < in_run; ++i) nodes.get(first + i, run[i]);
        for (uint32_t i = 0; i < in_run; ++i) {
            if (!coder.begin()) return false;
            CodePlaces(coder, nodes, places, run[i]);
        }
        for (uint32_t i = 0; i < in_run; ++i) {
            if (!coder.begin()) return false;
            CodeNormals(coder, normals, run[i]);
            nodes.put(first + i, run[i]);
        }
        for (uint32_t i = 0; kHasColour && i < in_run; ++i) {
            if (!coder.begin()) return false;
            CodeColour(coder, colours, run[i]);
            nodes.put_colour(first + i, run[i].colour);
        }
    }
    return places.left_in_group == 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#endif
