// The leaves of a model of triangles: their corners on the lattice, their circles, and who their neighbours
// are.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "mesh/mesh.h"
#include "splat/build/tree.h"

namespace splat {

// The smallest circle that holds a triangle: about its longest side where it is right or obtuse, through its
// corners where it is acute.  (Hybrid point and triangle viewer, section 3.1.)
struct TriangleCircle {
    enum class Kind { acute, obtuse, degenerate };  // right is obtuse; degenerate: without area
    glm::dvec3 centre;
    double radius;
    Kind kind;
};
TriangleCircle smallest_circle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

struct TriangleCounts {
    uint64_t acute = 0, obtuse = 0, degenerate = 0;  // as the lattice has them
    uint64_t flattened = 0;        // of the degenerate, those that have an area in the input
    uint64_t merged_vertices = 0;  // positions of the input that the lattice does not tell from others
    uint64_t smooth = 0;           // shaded by their corners' normals
};

struct TriangleLeaves {
    uint32_t lattice_bits = 1;
    double step = 0.5;                    // of the lattice, model units
    std::vector<glm::ivec3> corners;      // by vertex of the input, on the lattice
    std::vector<uint32_t> normals;        // by vertex: corner normal codes, 0: none
    bool normals_are_given = false;       // by the input, which so says what is smooth
    std::vector<glm::u32vec3> triangles;  // of the input: vertices
    std::vector<uint8_t> is_smooth;       // by triangle: shaded by its corners' normals

    glm::dvec3 at(uint32_t vertex) const { return glm::dvec3(corners[vertex]) * step; }
};

// How the model lies in the world: model = (position + offset) * inverse_scale.
struct Placement {
    glm::dvec3 offset;
    double inverse_scale;
};

// Puts the mesh's vertices on a lattice that is fine beside its triangles: 512 steps to the middle one's
// radius, 64 to that of one in fifty, from 16 bits to
// kMaxLatticeBits.  is_used: by vertex, whether a triangle has it.
// Takes positions and triangles out of the mesh; `leaves` are the triangles' circles' centres, in model
// units, in the input's order.
TriangleLeaves make_triangle_leaves(mesh::Mesh& mesh, std::span<const uint8_t> is_used,
                                    const Placement& placement, std::vector<TreePoint>& leaves,
                                    TriangleCounts& counts);

// Which triangles of other subtrees have a vertex in common with those of a subtree.
class TriangleNeighbours {
  public:
    // Leaves in tree order; where the subtrees begin.
    TriangleNeighbours(const TriangleLeaves& leaves, std::span<const TreePoint> points,
                       std::span<const uint32_t> subtree_begin);

    // Triangles, as numbers of the input.  All that have one of the vertices that are_owned() by the subtree;
    // but for vertices that many subtrees share, all that have any of its vertices.
    std::span<const uint32_t> of(size_t subtree) const { return strangers_[subtree]; }
    // Each vertex of a triangle is owned by one subtree.
    bool is_owned(uint32_t vertex, size_t subtree) const {
        return !is_shared_[vertex] || sharers_of(vertex).front().subtree == subtree;
    }

  private:
    struct Sharer {
        uint32_t vertex, subtree;
        auto operator<=>(const Sharer&) const = default;
    };
    std::span<const Sharer> sharers_of(uint32_t vertex) const;
    void find_sharers(size_t subtrees);
    template <class Use>
    void for_triangles(size_t subtree, const Use& use) const;

    const TriangleLeaves& leaves_;
    std::span<const TreePoint> points_;
    std::span<const uint32_t> subtree_begin_;
    std::vector<uint8_t> is_shared_;  // by vertex: subtrees share it
    std::vector<Sharer> sharers_;
    std::vector<std::vector<uint32_t>> strangers_;
};

}  // namespace splat
