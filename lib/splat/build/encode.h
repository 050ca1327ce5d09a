// Encoding: from leaves in tree order to node codes, top-down and in closed loop: a node is coded
// against its decoded parent, and its ellipsoid is fitted after centre and normal were coded, to
// cover its share of the surface as decoded.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "splat/build/fit.h"
#include "splat/build/surface.h"
#include "splat/build/tree.h"
#include "splat/node.h"

namespace splat {

// Node codes of a subtree or of the upper tree, with what is needed to lay them out.
struct CodedTree {
    static constexpr int32_t kLeaf = -1;

    std::vector<uint16_t> attitude, place, colour;
    std::vector<uint8_t> shape;
    // Group of a node's children; kLeaf; in the upper tree, -2 - s for the root of subtree s.
    std::vector<int32_t> child_group;
    struct Group {
        uint32_t first, count;
    };
    std::vector<Group> groups;
    std::vector<Node> decoded;   // dropped once errors are set
    std::vector<uint32_t> leaf;  // by node, of leaves that are triangles: which leaf of the model

    size_t size() const { return attitude.size(); }
    void reserve(size_t nodes);
    // Appends child k of a fitted group, a leaf for now.
    void add(const GroupFit& fit, size_t k, glm::u8vec3 colour, const Node& parent);
};

// Processor time of the parts of encoding, milliseconds, all threads together.
struct EncodeTimes {
    double surface = 0, fit = 0, leaf_errors = 0, inner_errors = 0;
    void add(const EncodeTimes& o) {
        surface += o.surface, fit += o.fit, leaf_errors += o.leaf_errors, inner_errors += o.inner_errors;
    }
};

// How well the codes fit, for reports and benchmarks.
struct FitCounts {
    uint64_t inserted = 0;  // one-child nodes between a large parent and a small child
    uint64_t leaves = 0, inner = 0;
    double leaf_inflation = 0, inner_inflation = 0;  // sums of decoded / needed radius
    float worst_leaf_inflation = 0;
    uint64_t open_fans =
        0;  // leaves whose faces do not go once round: their error is that to their own faces
    EncodeTimes ms;
    void add(const FitCounts& o);
    void count(const GroupFit& fit, size_t k, bool is_leaf);
};

// Codes the subtree under its decoded parent.  Group 0 is the root alone.  Errors are set; `decoded` holds
// the root only.  Appends to `boundary` the edges (leaf, leaf) that have a face on one side only, or faces of
// clashing sense; an edge within the subtree may come twice.
CodedTree encode_subtree(const SubtreeInput& input, std::span<const GapSide> gap_sides, const Node& parent,
                         FitCounts& counts, std::vector<glm::u32vec2>& boundary);

// The same of a surface of triangle leaves.
CodedTree encode_triangles(Surface&& surface, std::span<const GapSide> gap_sides, bool has_colour,
                           const Node& parent, FitCounts& counts);

}  // namespace splat
