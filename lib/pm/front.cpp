#include "pm/front.h"

#include <algorithm>

namespace pm {

Front::Front(const Hierarchy& hierarchy) : face_count_(hierarchy.base_faces.size()) {
    grow(hierarchy);
}

void Front::grow(const Hierarchy& hierarchy) {
    hierarchy_ = hierarchy;
    split_.resize(hierarchy.details(), 0);
    dependents_.resize(hierarchy.details(), 0);
}

int Front::added_faces(uint32_t d) const {
    const SplitFaces& faces = hierarchy_.faces[d];
    return int(faces.left_cut() != kNone) + int(faces.right_cut() != kNone);
}

bool Front::can_split(uint32_t d) const {
    const uint32_t parent = hierarchy_.parent[d], needs = hierarchy_.needs[d];
    return !is_split(d) && (parent == kNone || is_split(parent)) && (needs == kNone || is_split(needs));
}

bool Front::can_collapse(uint32_t d) const {
    return is_split(d) && dependents_[d] == 0;
}

void Front::count_dependence(uint32_t d, int by) {
    for (const uint32_t on : {hierarchy_.parent[d], hierarchy_.needs[d]})
        if (on != kNone) dependents_[on] += uint32_t(by);
}

void Front::split(uint32_t d) {
    split_[d] = 1;
    ++split_count_;
    face_count_ += uint64_t(added_faces(d));
    count_dependence(d, 1);
}

void Front::collapse(uint32_t d) {
    split_[d] = 0;
    --split_count_;
    face_count_ -= uint64_t(added_faces(d));
    count_dependence(d, -1);
}

void Front::assign(std::span<const uint32_t> details) {
    std::fill(split_.begin(), split_.end(), uint8_t(0));
    std::fill(dependents_.begin(), dependents_.end(), 0u);
    split_count_ = 0;
    face_count_ = hierarchy_.base_faces.size();
    for (const uint32_t d : details) split(d);
}

uint32_t Front::active(uint32_t vertex) const {
    // A vertex is there once it is born; before, its surface belongs to the vertex that it will be split
    // from.
    while (vertex >= hierarchy_.base_vertices && !is_split(vertex - hierarchy_.base_vertices))
        vertex = hierarchy_.kept[vertex - hierarchy_.base_vertices];
    return vertex;
}

std::vector<glm::u32vec3> Front::faces() const {
    std::vector<uint32_t> active_of(hierarchy_.vertices());
    for (uint32_t v = 0; v < hierarchy_.base_vertices; ++v) active_of[v] = v;
    for (uint32_t d = 0; d < hierarchy_.details(); ++d)
        active_of[hierarchy_.born_by(d)] =
            is_split(d) ? hierarchy_.born_by(d) : active_of[hierarchy_.kept[d]];
    std::vector<glm::u32vec3> faces;
    faces.reserve(face_count_);
    const auto add = [&](const glm::u32vec3& leaves) {
        if (leaves.x != kNone)
            faces.emplace_back(active_of[leaves.x], active_of[leaves.y], active_of[leaves.z]);
    };
    for (const glm::u32vec3& face : hierarchy_.base_faces) add(face);
    for (uint32_t d = 0; d < hierarchy_.details(); ++d)
        if (is_split(d)) add(hierarchy_.faces[d].left), add(hierarchy_.faces[d].right);
    return faces;
}

std::vector<uint32_t> Front::vertices() const {
    std::vector<uint32_t> vertices;
    vertices.reserve(hierarchy_.base_vertices + split_count_);
    for (uint32_t v = 0; v < hierarchy_.base_vertices; ++v) vertices.push_back(v);
    for (uint32_t d = 0; d < hierarchy_.details(); ++d)
        if (is_split(d)) vertices.push_back(hierarchy_.born_by(d));
    return vertices;
}

}  // namespace pm
