// Any triangles as an oriented manifold: cut where they are not one.
//
// About an edge of more than two faces these are taken in the order of their angles, and paired as solids
// that touch there have them: an edge that runs one way with the next one behind it that runs the other way,
// as parentheses pair. What is left over is cut.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pm/model.h"

namespace pm {

// Every directed edge is that of one face at most, and the faces about every vertex are one fan, open or
// closed.
struct Manifold {
    std::vector<glm::u32vec3> faces;
    std::vector<uint32_t> source;  // by vertex: the input's.  Vertices that are cut off from others come
                                   // last, until they are sorted
    std::vector<Weld> welds;       // of these

    uint64_t unreferenced = 0;     // vertices of the input without a face, left out
    uint64_t duplicate_faces = 0;  // left out: faces with the same corners in the same sense
    uint64_t cut_edges =
        0;  // of more than two faces, or of two that run the same way, before they are paired
    std::vector<glm::u32vec2> boundary;  // directed edges without one that runs against them
};

// `triangles` name vertices of `positions`, none of them twice.  O(n log n) in the largest number of
// faces about a vertex, else linear; the same answer whatever the number of threads.
Manifold make_manifold(std::span<const glm::u32vec3> triangles, std::span<const glm::vec3> positions);

// Extent of the widest boundary: the longest diagonal of the boxes about connected boundary edges.
double widest_gap(const Manifold& surface, std::span<const glm::dvec3> positions);

}  // namespace pm
