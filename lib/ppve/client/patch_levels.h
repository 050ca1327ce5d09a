// A patch at several resolutions, for the client: the samples as they came, and decimated by 2, 4, ... each
// way.
//
// Ge et al. 2006, sections 5.1 and 5.2; of its two ways of decimation the direct one: of each square of 2 x 2
// samples the mean colour, the least depth and, where there are some, the mean normal.  And the cone of
// normals that the paper leaves to its future work (Shirman, Abi-Ezzi 1993).
#pragma once

#include <memory>
#include <vector>

#include "ppve/patch.h"

namespace ppve {

// All normals are within the angle of the axis, each turned to the side from which the point was sampled.  A
// cosine of -1 ("any direction") where some point has no normal.
struct NormalCone {
    glm::vec3 axis{0, 0, 1};
    float cos_half_angle = -1;
};

struct PatchLevels {
    std::shared_ptr<const Patch> patch;
    std::vector<PatchPoints> coarser;  // [k]: decimated by 2^(k + 1) each way, from the patch's anchor
    NormalCone cone;

    size_t levels() const { return 1 + coarser.size(); }
    const PatchPoints& points(size_t level) const {
        return level == 0 ? patch->points() : coarser[level - 1];
    }
    size_t bytes() const;  // without the patch
};

// As many coarser levels as have fewer than 3/4 of the points of the one before, at most kMostCoarser.  Some
// 20 ns a point.
constexpr size_t kMostCoarser = 4;
std::shared_ptr<const PatchLevels> decimate(std::shared_ptr<const Patch> patch, double unit);

// True only if every point of the patch is seen from the side that it was not sampled from.
bool faces_away(const PatchLevels& patch, const glm::dvec3& eye, double unit);

}  // namespace ppve
