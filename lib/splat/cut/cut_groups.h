// Sibling groups, many at a time: decoded, culled, drawn or listed to be opened.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "geom/splat_batch.h"
#include "splat/cut/cut_view.h"

namespace splat {

constexpr int kMaxLanes = 16;  // of a vector

// A node to be opened.
struct Opening {
    glm::vec3 at;  // centre - pivot
    float radius;
    glm::vec3 normal;
    int16_t cone;
    uint8_t children;
    bool is_inside;  // wholly inside the four sides, those of the picture for the top and of the raster below
    bool may_hide = true;  // part of it may be hidden
    uint16_t level = 0;    // of the tree; 0 is the root
    uint32_t slot;         // of its first child, in `block`
    uint64_t block;
};

// Sibling groups of one block, a lane a node: what they and their parents are, and what became of them.
// Groups are short and vectors long, so that as many as fit are worked on together.
struct Chunk {
    static constexpr int kNodes = 128;
    static constexpr int kLanes = kNodes + kMaxLanes;  // the last vector may reach beyond the nodes
    static constexpr uint32_t kChildrenMissing = 16, kParentInside = 32, kParentMayHide = 64;

    int count = 0;
    alignas(64) std::array<uint32_t, kLanes> code;   // attitude, and place in the high half
    alignas(64) std::array<uint32_t, kLanes> shape;  // and flags
    alignas(64) std::array<uint32_t, kLanes> slot, colour;
    alignas(64) std::array<float, kLanes> parent_at[3], parent_normal[3], parent_radius;
    alignas(64) std::array<int32_t, kLanes> parent_cone;
    std::array<uint8_t, kNodes>
        missing{};  // by group: bits of the nodes whose children (or triangles) are not there

    // Leaves that are to be drawn as triangles.
    uint32_t triangle_count = 0;
    alignas(64) std::array<uint32_t, kLanes> triangles;

    // Of the nodes that are to be opened, which the first `open_count` of `open` name.
    uint32_t open_count = 0;
    alignas(64) std::array<uint32_t, kLanes> open, inside;
    alignas(64) std::array<float, kLanes> at[3], offset[3], normal[3], radius;
    alignas(64) std::array<int32_t, kLanes> cone;
    // Where the view is profiled: the smallest threshold at which the node is drawn, and its diameter,
    // pixels.  Where waiting nodes are listed: the error of what is drawn, and its diameter.
    alignas(64) std::array<float, kLanes> needed, size;
};

// Decodes the groups of `parents`, culls them, lists in `chunk` what is to be opened, and appends what is to
// be drawn to `batch`, which has room for Chunk::kLanes more.
void cut_groups(std::span<const Opening> parents, const BlockView& block, const CutView& view, Chunk& chunk,
                geom::SplatBatch& batch, CutCounts& counts);

}  // namespace splat
