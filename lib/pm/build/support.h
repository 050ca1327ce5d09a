// What the input's surface below each vertex of a mesh that is being simplified is like: leaves, radius,
// error, cone.
//
// The support of a node is the union of the input's faces with a corner at a leaf below it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pm/build/rings.h"

namespace pm {

// All normals within half_angle (radians) of a unit vector.  No normals at all: below 0; more than a cone
// holds: kWide. Rounding is upwards.
struct NormalCone {
    static constexpr float kWide = 4;
    glm::vec3 axis{0, 0, 1};
    float half_angle = -1;

    bool is_empty() const { return half_angle < 0; }
    bool is_useful() const { return !is_empty() && half_angle < 1.5707963f; }
};

// The smallest cone that holds both.
NormalCone merged(const NormalCone& a, const NormalCone& b);

// Unit space.  About the position of the node's vertex.
struct Support {
    double radius = 0;
    // The largest distance of a leaf below the node to the faces about its vertex and its neighbours, when it
    // had just been made; or of a leaf below one of the neighbours, where making the node has moved the
    // surface away from it.  Not a bound on what is seen later, when the faces there are others: measured, it
    // holds for 99.9 % of a surface.
    double error = 0;
    NormalCone cone;
    // Of the error, what is of leaves below neighbours; 0: nothing.
    double neighbours_error = 0;
};

class Supports {
  public:
    // Of the input itself.
    Supports(std::span<const glm::dvec3> positions, size_t face_count, const Rings& rings);

    // What follows comes in another pass over the mesh.
    void begin_pass();
    // A face has got another corner, or is gone.
    void change(uint32_t face) { changed_[face] = pass_; }

    // What was below `removed` is below `kept` now.
    void join(uint32_t removed, uint32_t kept);

    // Of the node that join() made, with the faces about it and about its neighbours as they are now.  Leaves
    // below it are all visited.  Several threads may measure nodes that differ.
    Support measure(uint32_t kept, std::span<const glm::u32vec3> corners, const Rings& rings);

    // Likewise, of a vertex about which the faces have changed: what measure() or set_error() knew before, or
    // how far the worst leaf below it is now, if that is more.
    double worst_error(uint32_t vertex, std::span<const glm::u32vec3> corners, const Rings& rings);
    double error(uint32_t vertex) const { return error_[vertex]; }
    uint32_t leaves(uint32_t vertex) const { return leaves_[vertex]; }  // below it
    void set_error(uint32_t vertex, double error) { error_[vertex] = error; }

  private:
    std::span<const glm::dvec3> positions_;
    std::vector<uint32_t> next_leaf_,
        last_leaf_;                     // a list of the leaves below each vertex; it comes first itself
    std::vector<float> leaf_radius_;    // of a leaf's own faces about it, rounded up
    std::vector<NormalCone> cones_;     // by vertex that is left
    std::vector<uint32_t> leaves_;      // likewise
    std::vector<double> error_;         // likewise: of the worst leaf below it, as far as was measured
    std::vector<uint32_t> worst_leaf_;  // likewise: which it is
    // By leaf: the face that was nearest when it was looked for last, which may be gone.
    std::vector<uint32_t> nearest_face_;
    // A leaf whose nearest face is as it was when its vertex was measured last is no farther off now.  So
    // most of them need no look.
    uint16_t pass_ = 0;
    std::vector<uint16_t> changed_;   // by face: the pass that did, 0 for none
    std::vector<uint16_t> measured_;  // by vertex: the pass behind which all leaves below it were looked at
};

}  // namespace pm
