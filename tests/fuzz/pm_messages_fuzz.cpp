// Any bytes as messages of the protocol of progressive meshes, as packets, records and states: what is taken
// writes the same bytes again or leaves a mesh, or Error.  Nothing else.
#include <algorithm>
#include <cstdint>

#include "core/error.h"
#include "pm/answer.h"
#include "pm/client.h"
#include "require.h"

namespace {

template <class Parse>
void check_message(std::span<const std::byte> bytes, const Parse& parse) {
    try {
        const auto again = pm::to_bytes(parse(bytes));
        require(std::equal(again.begin(), again.end(), bytes.begin(), bytes.end()),
                "a message writes its bytes again");
    } catch (const core::Error&) {
        // rejecting is fine
    }
}

void require_mesh(const pm::Replica& replica) {
    pm::Front front(replica.hierarchy());
    for (uint32_t s = 0; s != replica.split_count(); ++s) {
        require(front.can_split(s), "what was received is closed");
        front.split(s);
    }
    for (const glm::u32vec3& face : front.faces())
        for (int i = 0; i != 3; ++i) require(face[i] < replica.vertex_count(), "corners are vertices");
}

// Two tetrahedra, to be split by whatever comes.
pm::Replica two_tetrahedra(bool is_open, bool has_bounds = true) {
    pm::Header header;
    header.depth = 40;
    header.base_vertices = 8;
    header.placement.extent = 10;
    std::vector<pm::VertexData> vertices(8);
    std::vector<pm::ChildData> nodes(has_bounds ? 8 : 0, pm::ChildData{false, 200, 40});
    std::vector<glm::u32vec3> faces;
    for (uint32_t v = 0; v != 8; ++v)
        vertices[v].position = glm::u32vec3(v * 1000, v % 3 * 2000, v % 5 * 700);
    for (const uint32_t v : {0u, 4u}) {
        faces.insert(faces.end(), {{v, v + 1, v + 2}, {v, v + 2, v + 3}, {v, v + 3, v + 1}});
        if (!is_open) faces.emplace_back(v + 1, v + 3, v + 2);
    }
    return pm::Replica(header, vertices, faces, nodes);
}

void check_packet(std::span<const std::byte> bytes, bool is_open) {
    pm::Replica replica = two_tetrahedra(is_open);
    pm::SplitModels models;
    pm::Sweep sweep(replica, pm::View(), replica.header().placement, pm::Culling::off);
    try {
        pm::take_packet(replica, models, sweep, 500, 0, bytes);
    } catch (const core::Error&) {
        // what was taken before stays
    }
    require_mesh(replica);
}

void check_one_way(std::span<const std::byte> bytes) {
    pm::Replica replica = two_tetrahedra(false, false);
    pm::SplitModels models;
    pm::PassCursor cursor(replica);
    try {
        pm::take_one_way(replica, models, cursor, 500, 0, bytes);
    } catch (const core::Error&) {
        // what was taken before stays
    }
    require_mesh(replica);
}

void check_list(std::span<const std::byte> bytes) {
    pm::Replica replica = two_tetrahedra(false);
    pm::SplitModels models;
    try {
        pm::take_list_packet(replica, models, std::vector<uint32_t>{0, 2, 3, 6}, 0, bytes);
    } catch (const core::Error&) {
        // what was taken before stays
    }
    require_mesh(replica);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const auto bytes = std::as_bytes(std::span(data, size));
    check_message(bytes, pm::parse_request);
    check_message(bytes, pm::parse_reply);
    check_packet(bytes, false);
    check_packet(bytes, true);
    check_one_way(bytes);
    check_list(bytes);
    try {
        const pm::ClientState state = pm::ClientState::from_bytes(bytes, "state");
        require_mesh(state.replica());
    } catch (const core::Error&) {
        // rejecting is fine
    }
    return 0;
}
