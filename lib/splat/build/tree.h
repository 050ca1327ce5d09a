// The order of the leaves: binary cuts at the middle of the longest axis.
//
// Above kSubtreeLeaves the cuts are free and follow the shape; below, they are moved to the nearest
// multiple of a power of the fan-out, so that sibling groups fill (format study: 4.9 bytes a vertex
// where free cuts take 5.4, and 1 to 2 % more splats), but for cuts through a wide gap, which stay where they
// are: a node with a few leaves from beyond a gap is as large as the gap, however deep it stands in the tree,
// and spoils coarse pictures.  Subtrees are the units of parallel work.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "splat/format.h"

namespace splat {

constexpr uint32_t kSubtreeLeaves =
    16807;  // 7^5: errors are found over neighbours within a subtree; 7^4 takes 1.4 times the splats

// A leaf's place and which input vertex it is.
struct TreePoint {
    glm::vec3 position;
    uint32_t vertex;
};

// A side of a cut through a gap: a child of the node of a subtree whose leaves it divides, whatever their
// number. Leaves are counted from the subtree's first.
struct GapSide {
    uint32_t node_begin, node_end;
    uint32_t begin, end;
};

// A node of the upper tree: a run of leaves, cut in two until it is a subtree.
struct UpperCut {
    uint32_t begin = 0, end = 0;  // leaves
    glm::vec3 low{0}, high{0};    // their bounding box
    std::unique_ptr<UpperCut> left, right;
    std::vector<GapSide> gap_sides;  // of a subtree: by node_begin, of these the longest first, and by begin
    bool is_subtree() const { return !left; }
    uint32_t size() const { return end - begin; }
};

// Sorts `points` into tree order (in parallel, the same for any number of threads) and returns the
// cuts above the subtrees.  At least one point; all finite.
std::unique_ptr<UpperCut> sort_into_tree(std::span<TreePoint> points);

// Leaves of each child of a node with `leaves` leaves inside a subtree: the largest power of
// the fan-out below `leaves`; the last child takes the remainder, and so does the last one before a gap's
// side. leaves >= 2.
constexpr uint32_t child_leaves(uint32_t leaves) {
    uint32_t q = 1;
    while (q * uint32_t(kMaxFanOut) < leaves) q *= uint32_t(kMaxFanOut);
    return q;
}

}  // namespace splat
