// How far the points of a node's disc are from the surface, in SIMD chosen at run time; the same for any
// vector length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "splat/node.h"
#include "splat/surface.h"

namespace splat {

// About some centre, across frame.n.
struct Disc {
    Frame frame;
    float radius;
    uint32_t flatness;  // code: how finely errors are told apart
};

// Bound on the distance of any point of a leaf's disc from the surface; centre: relative to the surface's
// base.
float leaf_error(const Surface& surface, uint32_t leaf, const glm::dvec3& centre, const Disc& disc);

// Bound on the distance from any point of a node's disc to the surface, given discs that each stay within
// their error of it: the disc is cut into 48 convex cells, and the distance to a convex set is largest at a
// cell's corners.  Of more than 64 parts the first are used.  is_fine: the worst cells are cut finer.
float nested_error(const Node& node, std::span<const Node* const> parts, bool is_fine);

// Nodes by the spheres of their discs; room for a vector more behind the last.
struct Spheres {
    std::vector<float> x, y, z, radius;
};
struct NodeRange {
    uint32_t first, count;
};
// Appends those nodes of the ranges whose spheres, times `part`, touch the one of `node` (which touches
// itself).
void touching(const Spheres& spheres, std::span<const NodeRange> ranges, uint32_t node, float part,
              std::vector<uint32_t>& out);

}  // namespace splat
