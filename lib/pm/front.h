// A vertex front: which details of a hierarchy are split, and the mesh that this makes.
//
// Kim, Lee, Kobbelt, section 4 (truly selective refinement), without its loop over cut vertices: a split is
// legal if its parent is split and what it needs is split, a collapse if nothing that is split depends on it.
// There is no other condition, and any order of legal steps to the same set makes the same mesh: the set of
// those faces whose leaf corners have three distinct active ancestors.
//
// Vertices stand for nodes: of a split vertex the kept child has the number of its parent, so an active node
// is told by its vertex.  A face exists where the split that adds it is done.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pm/model.h"

namespace pm {

class Front {
  public:
    // The base mesh.  The arrays behind `hierarchy` outlive the front, or grow() is called.
    explicit Front(const Hierarchy& hierarchy);

    // The same hierarchy with more details behind the old ones, or moved: a client that has received some.
    // What is split stays split.
    void grow(const Hierarchy& hierarchy);

    bool is_split(uint32_t detail) const { return split_[detail] != 0; }
    bool can_split(uint32_t detail) const;     // not split, and what it depends on is
    bool can_collapse(uint32_t detail) const;  // split, and nothing split depends on it
    void split(uint32_t detail);               // it can_split()
    void collapse(uint32_t detail);            // it can_collapse()

    // To this set, whatever was split before.  `details` rise, and hold what they depend on.
    void assign(std::span<const uint32_t> details);

    uint32_t split_count() const { return split_count_; }
    uint64_t face_count() const { return face_count_; }

    // The vertex of the active node above a leaf (or any node) of `vertex`.  Costs the depth.
    uint32_t active(uint32_t vertex) const;

    // The faces of the front, by its active vertices: first the base mesh's, then two or one a split, by
    // detail. Every corner of the base faces and of the faces that splits add is looked up once: a pass over
    // all details.
    std::vector<glm::u32vec3> faces() const;

    // The active vertices, rising.
    std::vector<uint32_t> vertices() const;

  private:
    int added_faces(uint32_t detail) const;
    void count_dependence(uint32_t detail, int by);

    Hierarchy hierarchy_;
    std::vector<uint8_t> split_;        // by detail
    std::vector<uint32_t> dependents_;  // by detail: split details whose parent or needs it is
    uint32_t split_count_ = 0;
    uint64_t face_count_ = 0;
};

}  // namespace pm
