#include "pm/extract.h"

#include <numeric>

namespace pm {

mesh::Mesh mesh_of(const Model& model, const Front& front) {
    const Header& h = model.header();
    const std::vector<uint32_t> active = front.vertices();
    // By vertex: the active one that it is welded to, or itself; then its number in the mesh.
    std::vector<uint32_t> as(model.vertices(), kNone), number(model.vertices(), kNone);
    for (const uint32_t v : active) as[v] = v;
    std::vector<WeldedVertex> welded;
    if (h.welds > 0)
        for (const uint32_t v : active)
            if (const uint16_t weld = model.weld_number(v); weld != 0)
                welded.push_back({model.exact_position(v), weld, v});
    join_welded(welded, as);
    mesh::Mesh mesh;
    mesh.origin = h.placement.origin;
    for (const uint32_t v : active) {
        if (as[v] != v) continue;
        number[v] = uint32_t(mesh.positions.size());
        mesh.positions.push_back(h.is_lossless()
                                     ? model.single(v)
                                     : glm::vec3(h.placement.low + model.unit(v) * h.placement.extent));
        if (h.has_colours()) mesh.colours.push_back(model.colour(v));
        if (h.has_normals()) mesh.normals.push_back(glm::vec3(decode_normal(model.normal_code(v))));
    }
    for (const glm::u32vec3& face : front.faces())
        mesh.triangles.emplace_back(number[as[face.x]], number[as[face.y]], number[as[face.z]]);
    return mesh;
}

mesh::Mesh mesh_of_level(const Model& model, uint32_t splits) {
    Front front(model.hierarchy());
    std::vector<uint32_t> first(splits);
    std::iota(first.begin(), first.end(), 0u);
    front.assign(first);
    return mesh_of(model, front);
}

}  // namespace pm
