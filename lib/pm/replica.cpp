#include "pm/replica.h"

#include <algorithm>

#include "core/error.h"

namespace pm {

Replica::Replica(const Header& header, std::vector<VertexData> vertices, std::vector<glm::u32vec3> faces,
                 std::span<const ChildData> nodes)
    : header_(header), has_bounds_(!nodes.empty()), mesh_(uint32_t(vertices.size()), std::move(faces)) {
    for (uint32_t v = 0; v != vertices.size(); ++v) {
        add_vertex(vertices[v]);
        add_node(v, kNone, has_bounds_ ? nodes[v] : kUnknownNode);
    }
}

void Replica::add_vertex(const VertexData& data) {
    vertices_.push_back(data);
    unit_.push_back(unit_from_exact(data.position, header_));
    vertex_node_.push_back(kNone);
}

void Replica::add_node(uint32_t vertex, uint32_t parent, const ChildData& data) {
    Node node;
    node.vertex = vertex;
    node.parent = parent;
    node.depth = parent == kNone ? uint16_t(0) : uint16_t(nodes_[parent].depth + 1);
    node.is_leaf = data.is_leaf;
    node.error = data.error;
    node.radius = data.radius;
    vertex_node_[vertex] = uint32_t(nodes_.size());
    nodes_.push_back(node);
}

NodeBounds Replica::bounds(uint32_t n) const {
    const Node& node = nodes_[n];
    return {unit_[node.vertex], node.error, node.radius, node.has_cone ? node.cone : ConeCodes{}};
}

glm::dvec3 Replica::world(uint32_t v) const {
    return header_.placement.world_from_unit(unit_[v]);
}

// ---- orders ----

bool Replica::precedes(uint32_t a, uint32_t b) const {
    if (a == b) return false;
    const bool a_is_deeper = nodes_[a].depth > nodes_[b].depth;
    const bool is_as_deep = nodes_[a].depth == nodes_[b].depth;
    while (nodes_[a].depth > nodes_[b].depth) a = nodes_[a].parent;
    while (nodes_[b].depth > nodes_[a].depth) b = nodes_[b].parent;
    if (a == b) return !is_as_deep && !a_is_deeper;
    while (nodes_[a].parent != nodes_[b].parent) a = nodes_[a].parent, b = nodes_[b].parent;
    // Roots are numbered as base vertices, and of siblings the kept child comes first.
    return a < b;
}

bool Replica::is_lower(uint32_t v, uint32_t than) const {
    const glm::u32vec3 &a = vertices_[v].position, &b = vertices_[than].position;
    for (int i = 0; i != 3; ++i)
        if (a[i] != b[i]) return a[i] < b[i];
    return precedes(vertex_node_[v], vertex_node_[than]);
}

void Replica::find_ring(uint32_t vertex, Ring& ring) const {
    mesh_.find_ring(vertex, ring);
    if (!ring.is_closed) return;
    const auto lowest = std::min_element(ring.neighbours.begin(), ring.neighbours.end(),
                                         [&](uint32_t a, uint32_t b) { return is_lower(a, b); });
    const auto turns = lowest - ring.neighbours.begin();
    std::rotate(ring.neighbours.begin(), lowest, ring.neighbours.end());
    std::rotate(ring.corners.begin(), ring.corners.begin() + turns, ring.corners.end());
}

// kNone where they are in two trees.
uint32_t Replica::common_ancestor(uint32_t a, uint32_t b) const {
    while (nodes_[a].depth > nodes_[b].depth) a = nodes_[a].parent;
    while (nodes_[b].depth > nodes_[a].depth) b = nodes_[b].parent;
    while (a != b && a != kNone) a = nodes_[a].parent, b = nodes_[b].parent;
    return a == b ? a : kNone;
}

void Replica::find_place(uint32_t n, const Ring& ring, SplitPlace& place) const {
    const Node& node = nodes_[n];
    place.vertex = vertices_[node.vertex];
    place.error = node.error, place.radius = node.radius;
    place.is_closed = ring.is_closed;
    place.ring.clear();
    for (const uint32_t v : ring.neighbours) place.ring.push_back(vertices_[v].position);
}

// The cut vertices differ from the split of their lowest common ancestor on.
uint32_t Replica::needs_of(Cuts cuts, const Ring& ring) const {
    if (cuts.left < 0 || cuts.right < 0) return kNone;
    return common_ancestor(vertex_node_[ring.neighbours[size_t(cuts.left)]],
                           vertex_node_[ring.neighbours[size_t(cuts.right)]]);
}

// ---- what arrives ----

void Replica::apply(uint32_t n, const SplitData& data, const Ring& ring) {
    const int count = int(ring.neighbours.size());
    const auto [left, right] = data.cuts;
    const bool is_whole = left >= 0 && right >= 0;
    if (left >= count || right >= count || left == right || (ring.is_closed && !is_whole))
        throw core::Error("split: its cut vertices are not in the ring");
    if (nodes_[n].depth + 1u > header_.depth) throw core::Error("split: it is deeper than the model");
    const uint32_t vertex = nodes_[n].vertex, split = split_count();
    const uint32_t needs = needs_of(data.cuts, ring);
    mesh_.split(vertex, ring, left, right);
    add_vertex(data.vertex);
    nodes_[n].kept_child = uint32_t(nodes_.size());
    nodes_[n].split = split;
    nodes_[n].needs = needs;
    split_node_.push_back(n);
    cuts_.push_back(data.cuts);
    kept_.push_back(vertex);
    parent_.push_back(nodes_[n].parent == kNone ? kNone : nodes_[nodes_[n].parent].split);
    needs_.push_back(needs == kNone ? kNone : nodes_[needs].split);
    add_node(vertex, n, has_bounds_ ? data.kept : kUnknownNode);
    add_node(uint32_t(vertices_.size()) - 1, n, has_bounds_ ? data.fresh : kUnknownNode);
}

void Replica::learn_cone(uint32_t node, ConeCodes cone) {
    nodes_[node].cone = cone;
    nodes_[node].has_cone = true;
}

void Replica::learn_cuts(uint32_t node, Cuts cuts, const Ring& ring) {
    const int count = int(ring.neighbours.size());
    if (cuts.left >= count || cuts.right >= count)
        throw core::Error("split: its cut vertices are not in the ring");
    nodes_[node].needs = needs_of(cuts, ring);
}

void Replica::forget_cuts() {
    for (Node& node : nodes_)
        if (node.split == kNone) node.needs = kNone;
}

SplitData Replica::split_data(uint32_t split) const {
    const auto child = [&](uint32_t n) {
        return ChildData{nodes_[n].is_leaf, nodes_[n].error, nodes_[n].radius};
    };
    const uint32_t kept = nodes_[split_node_[split]].kept_child;
    SplitData data;
    data.cuts = cuts_[split];
    data.vertex = vertices_[vertex_count() - split_count() + split];
    data.kept = child(kept), data.fresh = child(kept + 1);
    return data;
}

Hierarchy Replica::hierarchy() const {
    static_assert(sizeof(SplitFaces) == 2 * sizeof(glm::u32vec3));
    const auto faces = mesh_.faces();
    Hierarchy tree;
    tree.base_vertices = vertex_count() - split_count();
    tree.base_faces = faces.first(faces.size() - 2 * size_t(split_count()));
    tree.kept = kept_;
    tree.parent = parent_;
    tree.needs = needs_;
    // A split adds its left and its right face in turn.
    tree.faces = {reinterpret_cast<const SplitFaces*>(faces.data() + tree.base_faces.size()), split_count()};
    return tree;
}

}  // namespace pm
