// Point patches: the points that one update adds to one cluster of the octree.
//
// Ge et al.  Point-based VR visualization for large-scale mesh datasets by real-time remote computation.
// 2006, section 4.4, where a patch is "the collection of points extracted from each server sampling frame".
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "ppve/depth_image.h"

namespace ppve {

// How the depth image of one update was sampled.
struct Sampling {
    uint64_t update = 0;  // number of the answer that brought it
    Frustum frustum{};
    double footprint_px = 1;  // as in DepthImage
};

// Points as a structure of arrays, of equal lengths; `normal` may be empty, which is "unknown".
struct PatchPoints {
    std::vector<float> x, y, z;    // from the patch's anchor, along the world's axes, tree units
    std::vector<uint32_t> colour;  // 0x00BBGGRR
    std::vector<uint16_t> normal;  // octahedral_code()

    size_t size() const { return x.size(); }
    bool has_normals() const { return !normal.empty(); }
    void reserve(size_t count, bool with_normals);
    // Appends point `i` of another, which has normals if this is to.
    void take(const PatchPoints& from, size_t i, bool with_normals);
};

// Positions are kept from the point of the patch that was nearest to the eye when it was sampled.  So the
// error of a position is at most 2^-22 of its distance from that eye, however far the eye is from the scene's
// middle, and where the patch is small, as in a narrow frustum, 2^-23 of the patch's size.
//
// Never changed once it is in a tree, so that it is shared by trees and by what is drawn of them.
class Patch {
  public:
    // `points` are not empty; `anchor` is in the world; `unit`: world units in a tree unit.
    Patch(std::shared_ptr<const Sampling> sampling, const glm::dvec3& anchor, double unit,
          PatchPoints points);

    const Sampling& sampling() const { return *sampling_; }
    const std::shared_ptr<const Sampling>& shared_sampling() const { return sampling_; }
    const PatchPoints& points() const { return points_; }
    const glm::dvec3& anchor() const { return anchor_; }
    size_t size() const { return points_.size(); }

    // The box around all points, from the anchor, in tree units.
    const glm::vec3& low() const { return low_; }
    const glm::vec3& high() const { return high_; }

    // What a pixel of the sampling stands for at a point, in tree units:
    //     footprint_at_anchor() + dot(footprint_slope(), offset of the point).
    float footprint_at_anchor() const { return footprint_; }
    const glm::vec3& footprint_slope() const { return footprint_slope_; }

    uint64_t hash() const { return hash_; }  // of all that both sides must agree on
    size_t bytes() const;                    // of memory

  private:
    std::shared_ptr<const Sampling> sampling_;
    glm::dvec3 anchor_;
    PatchPoints points_;
    glm::vec3 low_, high_;
    float footprint_;
    glm::vec3 footprint_slope_;
    uint64_t hash_;
};

}  // namespace ppve
