#include "pm/build/locality.h"

#include <algorithm>
#include <numeric>

#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace pm {

namespace {

// Every third bit of 21.
uint64_t spread(uint64_t x) {
    x = (x | x << 32) & 0x001f00000000ffff;
    x = (x | x << 16) & 0x001f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    return (x | x << 2) & 0x1249249249249249;
}

uint64_t place_on_curve(const glm::dvec3& unit) {
    const glm::dvec3 cell = glm::clamp(unit, 0.0, 1.0) * double((1 << 21) - 1);
    return spread(uint64_t(cell.x)) | spread(uint64_t(cell.y)) << 1 | spread(uint64_t(cell.z)) << 2;
}

// By number: the vertex that gets it.
std::vector<uint32_t> order_of(std::span<const glm::dvec3> positions) {
    std::vector<std::pair<uint64_t, uint32_t>> keys(positions.size());
    core::parallel_for(
        keys.size(),
        [&](size_t v) {
            keys[v] = {place_on_curve(positions[v]), uint32_t(v)};
        },
        4096);
    core::parallel_sort(keys.begin(), keys.end());
    std::vector<uint32_t> order(keys.size());
    std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
    return order;
}

uint32_t first_vertex(const glm::u32vec3& face) {
    return std::min({face.x, face.y, face.z});
}

void sort_faces(std::vector<glm::u32vec3>& faces, size_t vertex_count) {
    std::vector<uint32_t> begin(vertex_count + 1, 0);
    for (const glm::u32vec3& face : faces) ++begin[first_vertex(face) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<glm::u32vec3> sorted(faces.size());
    for (const glm::u32vec3& face : faces) sorted[begin[first_vertex(face)]++] = face;
    faces = std::move(sorted);
}

}  // namespace

void sort_by_place(Manifold& surface, std::span<const glm::dvec3> positions) {
    const std::vector<uint32_t> order = order_of(positions);
    std::vector<uint32_t> number(order.size()), source(order.size());
    for (uint32_t v = 0; v < order.size(); ++v) number[order[v]] = v, source[v] = surface.source[order[v]];
    surface.source = std::move(source);
    for (glm::u32vec3& face : surface.faces) face = {number[face.x], number[face.y], number[face.z]};
    for (glm::u32vec2& edge : surface.boundary) edge = {number[edge.x], number[edge.y]};
    for (Weld& weld : surface.welds) weld = {number[weld.copy], number[weld.of]};
    sort_faces(surface.faces, order.size());
}

}  // namespace pm
