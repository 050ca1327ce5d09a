// The surface about the triangle leaves of a subtree.
#pragma once

#include "splat/build/surface.h"
#include "splat/build/triangle_leaves.h"

namespace splat {

struct TriangleSubtree {
    size_t number = 0;
    uint32_t begin = 0, end = 0;        // leaves, in tree order
    std::span<const TreePoint> points;  // all of the model's
    const TriangleNeighbours* neighbours = nullptr;
    std::span<const glm::u8vec3> colours;  // by input vertex, or empty
};

// Also sets, in `leaves`, which of the subtree's are smooth, and the normals of the vertices that the subtree
// owns, where the input gives none; and appends to `boundary` the edges (vertex, vertex) at such vertices
// that have a face on one side only, or faces of clashing sense.  Returns how many of these vertices have
// such an edge in open_fans.
Surface gather_triangles(const TriangleSubtree& input, TriangleLeaves& leaves,
                         std::vector<glm::u32vec2>& boundary, uint64_t& open_fans);

}  // namespace splat
