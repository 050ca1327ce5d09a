// How far the points of a node's disc are from the surface, in SIMD chosen at run time; the same for any
// vector length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "splat/build/surface.h"
#include "splat/node.h"

namespace splat {

// A leaf's disc: across frame.n.
struct LeafDisc {
    uint32_t leaf;
    glm::dvec3 centre;  // relative to the surface's base
    Frame frame;
    float radius;
    uint32_t flatness;  // code: how finely errors are told apart
};

// For each of some leaves that are near each other a bound on the distance of any point of its disc from the
// surface.  Of the surface only the faces' marks are changed; now: 0 before the first call, what the last
// call left before another.
void leaf_errors(Surface& surface, std::span<const LeafDisc> discs, uint32_t& now, std::span<float> errors);

// The same of one disc by the faces about some leaves, wherever they are; of more than 256 the first are
// used.
float faces_error(const Surface& surface, const LeafDisc& disc, std::span<const uint32_t> leaves);

// The same of a leaf that is a triangle, inside whose disc its corners are.
float triangle_error(const Surface& surface, const LeafDisc& disc);

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
// Those nodes of the ranges whose spheres, times `part`, touch the one of `node` (which touches itself).
// They stand in `room`, which is made larger where it must be, until the next call.
std::span<const uint32_t> touching(const Spheres& spheres, std::span<const NodeRange> ranges, uint32_t node,
                                   float part, std::vector<uint32_t>& room);

}  // namespace splat
