// A triangle mesh that only ever gains vertices by splits, with the ring of each vertex at hand.
//
// Corners stand for faces and their vertices: corner 3 f + i is that of face f at its vertex i.  Faces are
// oriented; a ring goes round its vertex counter-clockwise, seen from the side from which the faces are.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pm/format.h"

namespace pm {

// The neighbours of a vertex in turn.  Faces lie between one and the next, and, where it is closed, between
// the last and the first.
struct Ring {
    bool is_closed = false;
    std::vector<uint32_t> neighbours;
    std::vector<uint32_t>
        corners;  // of the vertex, in the face behind each neighbour; one less where it is open
};

class RingMesh {
  public:
    RingMesh() = default;
    // Throws core::Error where corners are no vertices or equal, an edge has three faces or two of one
    // orientation, or a vertex has more than one ring.
    RingMesh(uint32_t vertex_count, std::vector<glm::u32vec3> faces);

    uint32_t vertex_count() const { return uint32_t(corner_.size()); }
    std::span<const glm::u32vec3> faces() const { return faces_; }

    // An open ring begins at the boundary, a closed one anywhere.  Empty for a vertex without faces.
    void find_ring(uint32_t vertex, Ring& ring) const;

    // Splits `vertex`, of which `ring` is the ring, into itself and a new vertex, to which the faces from
    // neighbour `left` on to neighbour `right` go; -1 where it is missing, and the boundary stands for it.
    // Adds two faces: (new, vertex, left) and (vertex, new, right), kNone thrice where one is missing.  Not
    // both are missing, they differ, and in a closed ring none is missing.
    void split(uint32_t vertex, const Ring& ring, int left, int right);

  private:
    uint32_t& at(uint32_t corner) { return faces_[corner / 3][int(corner % 3)]; }
    uint32_t vertex_at(uint32_t corner) const { return faces_[corner / 3][int(corner % 3)]; }
    void link_faces();
    void check_rings() const;
    void join(uint32_t a, uint32_t b);

    std::vector<glm::u32vec3> faces_;
    std::vector<glm::u32vec3>
        opposite_;                  // by face: the corner on the other side of the edge that a corner faces
    std::vector<uint32_t> corner_;  // by vertex: one of its corners; that at the boundary, if it is there
};

}  // namespace pm
