// What a client holds of a model: the base mesh and all splits that it has received, as a tree of nodes and
// the finest mesh that they make.  The server finds what it needs of it in the model, by its sent bits
// (sent_tree.h).
//
// Kim, Lee, Kobbelt, section 5.2: the partially constructed vertex hierarchy.  Where the paper's client is
// sent fundamental cut vertices by name, this one is told which neighbours of the vertex in its finest mesh
// the cut vertices are now, and follows them from there: every later split of a cut vertex says itself which
// faces go to its new child.
//
// All that packets are coded by (rings, their order, predictions) depends on what is split alone, and not on
// the order in which it was: so a server needs to know no more than that.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "pm/bounds.h"
#include "pm/format.h"
#include "pm/model.h"
#include "pm/ring_mesh.h"
#include "pm/split_code.h"

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
    glm::dvec3 unit(uint32_t v) const { return unit_[v]; }
    glm::dvec3 world(uint32_t v) const;

    // The ring of a vertex.  A closed one begins with the neighbour of the lowest position (x, then y, then
    // z), and of equal ones with that which precedes().
    void find_ring(uint32_t vertex, Ring& ring) const;

    // What its split is coded by; `ring` is that of its vertex.
    void find_place(uint32_t node, const Ring& ring, SplitPlace& place) const;

    // Splits a node that is not split and no leaf.  Throws core::Error where the cuts are none of this ring,
    // or the tree would be deeper than the header says.
    void apply(uint32_t node, const SplitData& split, const Ring& ring);

    void learn_cone(uint32_t node, ConeCodes cone);
    // The two cut vertices of a node that cannot be split yet.
    void learn_cuts(uint32_t node, Cuts cuts, const Ring& ring);
    void set_needs(uint32_t node, uint32_t needs) { nodes_[node].needs = needs; }
    // Of nodes that are not split yet: a record does not hold them.
    void forget_cuts();

    // ---- the tree, for sweep.h and tree_walk.h ----

    uint32_t end_of_splits() const { return uint32_t(nodes_.size()); }  // nodes that are split are below
    template <class Use>
    void for_each_split(const Use& use) const {
        for (const uint32_t n : split_node_) use(n);
    }
    template <class Use>
    void for_each_root(const Use& use) const {
        for (uint32_t n = 0; n != vertex_count() - split_count(); ++n) use(n);
    }
    bool is_split(uint32_t n) const { return nodes_[n].split != kNone; }
    bool is_leaf(uint32_t n) const { return nodes_[n].is_leaf; }
    uint32_t parent(uint32_t n) const { return nodes_[n].parent; }
    uint32_t needs(uint32_t n) const { return nodes_[n].needs; }
    std::array<uint32_t, 2> children(uint32_t n) const {
        return {nodes_[n].kept_child, nodes_[n].kept_child + 1};
    }
    uint8_t error_code(uint32_t n) const { return nodes_[n].error; }
    NodeBounds bounds(uint32_t n) const;
    // True where `a` comes before `b` in the order of the tree: by base vertex, a node before its children,
    // the kept child's before the new one's.
    bool precedes(uint32_t a, uint32_t b) const;

    // What apply() was told of a split: with it, and the same ones before it, it can be done again.
    SplitData split_data(uint32_t split) const;

    // For pm::Front: the splits received as details.  Valid until the next split.
    Hierarchy hierarchy() const;

  private:
    bool is_lower(uint32_t vertex, uint32_t than) const;
    uint32_t common_ancestor(uint32_t a, uint32_t b) const;
    uint32_t needs_of(Cuts cuts, const Ring& ring) const;
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
    std::vector<Cuts> cuts_;                                    // positions in the ring of that time
};

}  // namespace pm
