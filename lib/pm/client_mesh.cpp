#include "pm/client_mesh.h"

#include <bit>
#include <filesystem>

#include "core/error.h"

namespace pm {

namespace {

constexpr const char* kScheme = "pm://";

}  // namespace

mesh::Mesh mesh_of(const Replica& replica, const Front& front) {
    const Header& header = replica.header();
    const std::vector<uint32_t> active = front.vertices();
    // By vertex: the active one that it is welded to, or itself; then its number in the mesh.
    std::vector<uint32_t> as(replica.vertex_count(), kNone), number(replica.vertex_count(), kNone);
    std::vector<WeldedVertex> welded;
    for (const uint32_t v : active) {
        as[v] = v;
        if (const VertexData& data = replica.vertex(v); data.weld != 0)
            welded.push_back({data.position, data.weld, v});
    }
    join_welded(welded, as);
    mesh::Mesh mesh;
    mesh.origin = header.placement.origin;
    for (const uint32_t v : active) {
        if (as[v] != v) continue;
        const VertexData& vertex = replica.vertex(v);
        number[v] = uint32_t(mesh.positions.size());
        if (header.is_lossless())
            mesh.positions.emplace_back(std::bit_cast<float>(vertex.position.x),
                                        std::bit_cast<float>(vertex.position.y),
                                        std::bit_cast<float>(vertex.position.z));
        else
            mesh.positions.push_back(
                glm::vec3(header.placement.low + replica.unit(v) * header.placement.extent));
        if (header.has_colours()) mesh.colours.push_back(vertex.colour);
        if (header.has_normals()) mesh.normals.push_back(glm::vec3(decode_normal(vertex.normal)));
    }
    for (const glm::u32vec3& face : front.faces())
        mesh.triangles.emplace_back(number[as[face.x]], number[as[face.y]], number[as[face.z]]);
    return mesh;
}

bool is_location(const std::string& text) {
    return text.starts_with(kScheme);
}

Location parse_location(const std::string& text) {
    const std::string rest = is_location(text) ? text.substr(std::string(kScheme).size()) : text;
    const size_t slash = rest.rfind('/');
    if (!is_location(text) || slash == rest.npos || slash == 0)
        throw core::UsageError("'" + text +
                               "' is no progressive mesh at a server; give pm://HOST:PORT/NAME, as in "
                               "pm://127.0.0.1:4100/dragon");
    if (std::error_code unknown; std::filesystem::is_socket(rest, unknown))
        throw core::UsageError("'" + text + "' names no model; give " + text + "/NAME, or " + text +
                               "/ where the server has one");
    return {net::parse_address(rest.substr(0, slash)), rest.substr(slash + 1)};
}

}  // namespace pm
