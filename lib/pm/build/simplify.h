// Simplifying a mesh to its floor by half-edge collapses, in passes of independent edges.
//
// Kim, Lee, Kobbelt, section 6.2: maximally independent edges of small error, so that the hierarchy is
// balanced: a vertex takes part once a pass.  What is not theirs: only the cheaper half of the candidates
// enters a pass, since a true order by error saves more splits than balance.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pm/build/support.h"

namespace pm {

// `removed` goes onto `kept`, along an edge.  The corners are those of `removed` in the faces that vanish,
// kNone for one that is not there: the left one is (removed, kept, cut), the right one (kept, removed, cut).
struct Collapse {
    uint32_t removed, kept;
    uint32_t left_corner, right_corner;
    Support support;  // of the node that it makes
};

struct SimplifyOptions {
    // Refuses collapses that turn a face by more than kFlipCosine, or by more than 90 degrees from the
    // input's face.
    bool flip_test = true;
};

struct SimplifyResult {
    std::vector<Collapse> collapses;  // in their order
    std::vector<glm::u32vec3>
        faces;  // all, by their corners at the end; those that vanished as they were then
    std::vector<uint32_t> base_faces;     // which of them are left
    std::vector<uint32_t> base_vertices;  // that are left, rising
    uint32_t passes = 0;
    uint64_t refused_links = 0, refused_flips = 0;
    double collapse_ms = 0, support_ms = 0;  // what was spent on collapses, and on measuring their supports
};

// `faces` make a manifold (manifold.h) of `positions` in unit space; every vertex has a face.  The same
// result whatever the number of threads.  `progress` is told how many collapses are done.
SimplifyResult simplify(std::span<const glm::dvec3> positions, std::span<const glm::u32vec3> faces,
                        const SimplifyOptions& options, const std::function<void(uint64_t)>& progress = {});

}  // namespace pm
