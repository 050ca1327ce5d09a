// How splits, cones and base meshes are coded in packets: pm-protocol(5) says it in words.
//
// What a split costs is its content alone.  Which node it splits is known to both sides (sweep.h), which
// neighbours are its cut vertices costs log2 of the ring, the new position is predicted from the ring that
// the new vertex will have, and bounds are told by their difference from those of the node that is split.
#pragma once

#include <span>
#include <vector>

#include "pm/bounds.h"
#include "pm/format.h"
#include "pm/range_coder.h"
#include "pm/split_data.h"

namespace pm {

// What a server says about the node that both sides look at next.
enum class Decision : uint32_t {
    split,  // its split follows
    later,  // something that it needs comes first
    cone,   // a cone of normals follows that stops it
    cuts,   // its cut vertices follow: what it needs is not wanted
    skip,   // not for this view
};

// Classes of the size that a residual is likely to have, in half octaves, and of its direction: little, more
// or much along the surface's normal.  Beyond kFineClasses, sizes are brought down to the last two by their
// low bits, which are noise.
constexpr size_t kFineClasses = 10, kAxisClasses = 3, kErrorClasses = 32;

// Learned from what was coded since the connection began; both sides have the same.
struct SplitModels {
    std::array<BitModel, 4> decision;
    BitModel climbs, climbs_to_needs;
    std::array<BitModel, 2> missing;  // in an open ring: left, right
    std::array<TreeModel<4>, 17> span;
    NumberModel<> long_span;
    std::array<std::array<SignedModel<20>, kAxisClasses>, kFineClasses + 2> position;
    std::array<SignedModel<32>, 3> exact;
    std::array<SignedModel<10>, 3> colour;
    std::array<SignedModel<10>, 2> normal;
    BitModel normal_is_known;
    std::array<std::array<BitModel, 2>, 2> is_welded;  // at a boundary, from a vertex that is
    NumberModel<17> weld;
    std::array<std::array<BitModel, 3>, kErrorClasses> leaf;
    std::array<NumberModel<9>, 3> error;
    std::array<SignedModel<8>, 12> radius;
    std::array<BitModel, 6> pass;                // one_way.h
    std::array<BitModel, kErrorClasses> listed;  // lists.h
};

template <class Coder>
Decision code_decision(Coder& coder, SplitModels& models, Decision decision) {
    uint32_t value = 0;
    while (value < 4 && coder.bit(models.decision[value], value < uint32_t(decision))) ++value;
    return Decision(value);
}

// What both sides know of a node that is to be split.
struct SplitPlace {
    VertexData vertex;  // its own
    uint8_t error = 0, radius = 0;
    bool is_closed = false;          // its ring, which begins as replica.h says
    std::vector<glm::u32vec3> ring;  // positions of the neighbours
};

// `split` is what is written, and what is returned is what was read: some split that can be applied, or
// core::Error where none can.  Children are told where bounds are.
template <class Coder>
SplitData code_split(Coder& coder, SplitModels& models, const Header& header, bool tells_bounds,
                     const SplitPlace& place, const SplitData& split);

// Of a node that waits for another one: none is missing, and they may be equal.
template <class Coder>
Cuts code_cuts(Coder& coder, size_t ring_size, Cuts cuts);

template <class Coder>
ConeCodes code_cone(Coder& coder, ConeCodes cone) {
    const uint16_t axis = uint16_t(coder.uniform(kAxisCodes, cone.axis));
    return {axis, uint8_t(coder.uniform(kAnyDirection + 1u, cone.angle))};
}

// The base mesh.  Counts are those of the header.
struct BaseMesh {
    std::vector<VertexData> vertices;
    std::vector<glm::u32vec3> faces;
    std::vector<ChildData> nodes;  // none where bounds are not told
};
std::vector<std::byte> encode_base(const Header& header, const BaseMesh& base);
// Throws core::Error where a corner is no vertex, or the bytes end too early.
BaseMesh decode_base(const Header& header, std::span<const std::byte> bytes, bool has_bounds = true);

}  // namespace pm
