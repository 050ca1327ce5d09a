// Redundancy elimination: what of a new depth image the client has already, and what the new image replaces.
//
// Ge et al. 2006, section 4.2: the points that the client has are drawn, one pixel each, into a reference
// depth map; a new sample is kept if it is nearer than the reference by more than epsilon.  A point that is
// coarser than the new sample then discards it, up to a third of the detail on a way towards a surface, and
// with an epsilon below the slope of a pixel half of all points are duplicates.  The default here:
//   - epsilon is the sample's footprint and its slope, the change of depth to the next pixel;
//   - points with a footprint above rho = 1.4 of the new ones' do not count;
//   - a sample goes where footprints of cached points, squares about them, overlap half of its pixel,
//     and one of them is drawn there: so a surface that was sampled all over stays known from all sides,
//     though many a pixel has no point's middle in it, and one point of a close-up does not stand for a far
//     view's pixel;
//   - such a coarse point is removed from the tree where new samples hold all its corners.  Both sides are
//   told
//     which (Removal), so that they need not come to the same conclusion.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "ppve/depth_image.h"
#include "ppve/messages.h"
#include "ppve/octree.h"

namespace ppve {

struct EliminationRule {
    Elimination kind = Elimination::filtered;
    double epsilon = 0;  // paper: world units, >= 0
    double rho = 1.4;    // filtered: of footprints
};

struct EliminationCounts {
    uint64_t samples = 0, kept = 0;  // of the new image
    // Left out although all that the tree has there is coarser than rho footprints (the paper's rule).
    uint64_t lost = 0;
    uint64_t removed = 0;  // points
};

struct Eliminated {
    std::vector<Removal> removed;
    EliminationCounts counts;
};

// Takes from `image` (depth code and colour 0) the samples that the tree makes redundant; says which points
// of the tree the image makes redundant.  The tree is not changed.  Parallel; the same result for any number
// of threads.  Time: some ns for each point in the frustum, and for each pixel.
Eliminated eliminate(const Octree& tree, const EliminationRule& rule, DepthImage& image);

// Removals as bytes, and back: a bit a point, zstd.  read_removals() throws core::Error for anything that
// write_removals() does not write; memory is bounded by `most_points`, of all patches named.
std::vector<std::byte> write_removals(std::span<const Removal> removals);
std::vector<Removal> read_removals(std::span<const std::byte> bytes, uint64_t most_points);

}  // namespace ppve
