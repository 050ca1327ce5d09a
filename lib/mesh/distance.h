// How far a point is from the surface of a mesh: the independent measure that error bounds are held against.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/mesh.h"

namespace mesh {

// The nearest point of the nearest triangle (of the nearest vertex, for a cloud), found in a tree of boxes.
//
// Keeps its own copy of the triangles' corners: 36 bytes a triangle and about 16 of boxes (while it is
// built, 52 more).  Built in parallel in O(n log n); the same answers whatever the number of threads.
// Vertices that no triangle uses do not count.
class SurfaceDistance {
  public:
    explicit SurfaceDistance(const Mesh& mesh);

    // In world units; infinity where nothing of the mesh is as near as `limit` (which may be infinity; a
    // close one is quicker), where the mesh is empty, and for a point that is not finite.  Degenerate
    // triangles count as the segments or points they are.  Off by some 1e-15 of the sum of the nearest
    // triangle's size, the distance, and the magnitudes of the origin and the point; for slivers up to 1e-8
    // of their width too large, never too small. Coordinates from 1e-30 to 1e30.  Thread-safe.
    double distance(const glm::dvec3& world_point, double limit) const;

  private:
    // A box, and below it either two nodes (the next one, and `right`) or `count` primitives from `first`.
    struct Node {
        glm::vec3 low, high;
        uint32_t right_or_first;
        uint32_t count;  // 0: an inner node
    };

    struct Item;
    void build(std::vector<Item>& items, const std::vector<glm::vec3>& corners, size_t node, size_t begin,
               size_t end);
    void build_leaf(const std::vector<Item>& items, const std::vector<glm::vec3>& corners, size_t node,
                    size_t begin, size_t end);
    double squared_distance(const glm::dvec3& point, uint32_t primitive) const;

    glm::dvec3 origin_;
    size_t corners_each_;             // 3, or 1 for a cloud
    std::vector<glm::vec3> corners_;  // of the primitives, in the order of the leaves
    std::vector<Node> nodes_;
};

}  // namespace mesh
