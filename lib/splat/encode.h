// Encoding: from leaves in tree order to node codes, top-down and in closed loop: a node is coded
// against its decoded parent, and its ellipsoid is fitted after centre and normal were coded, to
// cover its share of the surface as decoded.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "splat/cover.h"
#include "splat/node.h"
#include "splat/tree.h"

namespace splat {

// Node codes of a subtree or of the upper tree, with what is needed to lay them out.
struct CodedTree {
    static constexpr int32_t kLeaf = -1;

    std::vector<uint16_t> attitude, place, colour;
    std::vector<uint8_t> shape;
    // Group of a node's children; kLeaf; in the upper tree, -2 - s for the root of subtree s.
    std::vector<int32_t> child_group;
    struct Group {
        uint32_t first, count;
    };
    std::vector<Group> groups;
    std::vector<Node> decoded;  // dropped once errors are set

    size_t size() const { return attitude.size(); }
};

// How well the codes fit, for reports and benchmarks.
struct FitCounts {
    uint64_t inserted = 0;        // one-child nodes between a large parent and a small child
    uint64_t leaves = 0, inner = 0;
    double leaf_inflation = 0, inner_inflation = 0;  // sums of decoded / needed radius
    float worst_leaf_inflation = 0;
    uint64_t open_fans = 0;       // leaves whose faces do not go once round: their error is that to their own faces
    void add(const FitCounts& o);
};

// What one node must cover and show.
struct Content {
    const PointArrays* points;        // relative to `base`, which is in model units
    size_t begin, end;
    glm::dvec3 base;
    const std::vector<glm::dvec3>* precise = nullptr;  // the same points in double, where float is too coarse
    glm::dvec3 normal{0};             // any length; 0: unknown
    const PointArrays* face_normals = nullptr;  // bounded by the cone; null: no cone
    size_t face_begin = 0, face_end = 0;
    glm::u8vec3 colour{0};
    bool is_leaf = false;
};

// Scratch of the encoder; one a thread.
class NodeEncoder {
  public:
    // Codes `content` under `parent`.  is_between is set where the code is much too large for the content and a
    // smaller one is in reach: the node then stands between, with the content as its one child.
    struct Result {
        uint16_t attitude = 0, place = 0;  // without children count and error
        uint8_t shape = 0;
        uint16_t colour = 0;
        Node node;
        float inflation = 1;  // decoded radius / radius of the sphere about the free centre
        bool is_between = false;
    };
    Result encode(const Content& content, const Node& parent, const Frame& parent_frame);

  private:
    FramePoints points_;
    PointArrays exact_;
};

// Rounds a node's error up to its code and sets it, in the codes and in tree.decoded.
void set_error(CodedTree& tree, size_t node, float error);

// Bound on the distance of a node's disc from the surface, by way of nodes below it (and below its
// neighbours) whose errors are known.
float error_over(const Node& node, std::span<const Node* const> parts);

// One subtree of a mesh or cloud.  Model units.
struct SubtreeInput {
    uint32_t begin = 0, end = 0;                     // leaves, in tree order
    std::span<const TreePoint> points;               // all of the model's
    std::span<const glm::u32vec3> faces;             // those that touch the subtree, as leaf numbers
    glm::dvec3 offset{0};                            // model = (position + offset) * inverse_scale
    double inverse_scale = 1;
    std::span<const glm::vec3> normals;              // by input vertex, or empty
    std::span<const glm::u8vec3> colours;            // by input vertex, or empty
    std::span<const float> cloud_radii;              // by input vertex, world units, for bare points

    glm::dvec3 model(uint32_t leaf) const {
        return (glm::dvec3(points[leaf].position) + offset) * inverse_scale;
    }
};

// Codes the subtree under its decoded parent.  Group 0 is the root alone.  Errors are set; `decoded` holds
// the root only.  Appends to `boundary` the edges (leaf, leaf) that have a face on one side only, or faces of
// clashing sense; an edge within the subtree may come twice.
CodedTree encode_subtree(const SubtreeInput& input, const Node& parent, FitCounts& counts,
                         std::vector<glm::u32vec2>& boundary);

}  // namespace splat
