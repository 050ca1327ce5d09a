// What a client holds of a model: the base mesh and all splits that it has received, as a tree of nodes and
// the finest mesh that they make.  The server builds the same, from its sent bits, for as long as it needs
// it.
//
// Kim, Lee, Kobbelt, section 5.2: the partially constructed vertex hierarchy.  Where the paper's client is
// sent fundamental cut vertices by name, this one is told which neighbours of the vertex in its finest mesh
// the cut vertices are now, and follows them from there: every later split of a cut vertex says itself which
// faces go to its new child.
//
// All that packets are coded by (rings, their order, predictions) depends on what is split alone, and not on
// the order in which it was: so a server that builds its replica anew goes on where it was.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pm/bounds.h"
#include "pm/format.h"
#include "pm/model.h"
#include "pm/ring_mesh.h"

namespace pm {

// A vertex between two splits.
struct Node {
    uint32_t vertex = 0;
    uint32_t parent = kNone;
    uint32_t kept_child = kNone;  // the node of the new vertex stands behind it
    uint32_t split = kNone;       // which of the replica's splits splits it
    uint32_t needs = kNone;       // a node that must be split before it, where that is known
    uint16_t depth = 0;
    uint8_t error = 0, radius = 0;  // where it is not a leaf
    bool is_leaf = true;            // of the model: it can never be split
    bool has_cone = false;          // it is known
    ConeCodes cone{};
};

struct VertexData {
    glm::u32vec3 position{0};  // lattice coordinates, or the bits of single precision where it is lossless
    glm::u8vec3 colour{0};
    uint16_t normal = 0xffff;
    uint16_t weld = 0;  // welds.h: what it is one with at its place
};

struct ChildData {
    bool is_leaf = true;
    uint8_t error = 0, radius = 0;
};
// What is known of a node where bounds are not told (service.h): it may be split.
constexpr ChildData kUnknownNode{false, 0, 0};

// One split, as a packet says it.
struct SplitData {
    int left = -1, right = -1;  // cut vertices: positions in the canonical ring; -1: missing
    VertexData vertex;          // of the new child
    ChildData kept, fresh;
};

class Replica {
  public:
    // Vertices and their nodes in the order of the model's base mesh; no nodes where bounds are not told.
    // Throws core::Error as RingMesh does.
    Replica(const Header& header, std::vector<VertexData> vertices, std::vector<glm::u32vec3> faces,
            std::span<const ChildData> nodes);

    const Header& header() const { return header_; }
    bool has_bounds() const { return has_bounds_; }
    std::span<const Node> nodes() const { return nodes_; }
    const Node& node(uint32_t n) const { return nodes_[n]; }
    const VertexData& vertex(uint32_t v) const { return vertices_[v]; }
    uint32_t vertex_count() const { return uint32_t(vertices_.size()); }
    uint32_t split_count() const { return uint32_t(kept_.size()); }
    uint32_t node_of_split(uint32_t split) const { return split_node_[split]; }
    uint32_t node_of_vertex(uint32_t v) const { return vertex_node_[v]; }  // its last one
    NodeBounds bounds(const Node& node) const;
    glm::dvec3 unit(uint32_t v) const { return unit_[v]; }
    glm::dvec3 world(uint32_t v) const;

    // The ring of a vertex.  A closed one begins with the neighbour of the lowest position (x, then y, then
    // z), and of equal ones with that which precedes().
    void find_ring(uint32_t vertex, Ring& ring) const;

    // Splits a node that is not split and no leaf.  Throws core::Error where the cuts are none of this ring,
    // or the tree would be deeper than the header says.
    void apply(uint32_t node, const SplitData& split, const Ring& ring);

    void learn_cone(uint32_t node, ConeCodes cone);
    // The two cut vertices of a node that cannot be split yet; -1: missing.
    void learn_cuts(uint32_t node, int left, int right, const Ring& ring);
    void set_needs(uint32_t node, uint32_t needs) { nodes_[node].needs = needs; }
    // Of nodes that are not split yet: a record does not hold them.
    void forget_cuts();

    // True where `a` comes before `b` in the order of the tree: by base vertex, a node before its children,
    // the kept child's before the new one's.
    bool precedes(uint32_t a, uint32_t b) const;

    // What apply() was told of a split: with it, and the same ones before it, it can be done again.
    SplitData split_data(uint32_t split) const;

    // For pm::Front: the splits received as details.  Valid until the next split.
    Hierarchy hierarchy() const;

    size_t memory_bytes() const;

  private:
    bool is_lower(uint32_t vertex, uint32_t than) const;
    uint32_t common_ancestor(uint32_t a, uint32_t b) const;
    uint32_t needs_of(int left, int right, const Ring& ring) const;
    void add_vertex(const VertexData& data);
    void add_node(uint32_t vertex, uint32_t parent, const ChildData& data);

    Header header_;
    bool has_bounds_;
    RingMesh mesh_;
    std::vector<Node> nodes_;
    std::vector<VertexData> vertices_;
    std::vector<glm::dvec3> unit_;
    std::vector<uint32_t> vertex_node_;
    std::vector<uint32_t> split_node_, kept_, parent_, needs_;  // by split
    std::vector<glm::ivec2> cuts_;                              // positions in the ring of that time
};

}  // namespace pm
