#include "pm/info.h"

#include <bit>

#include "core/error.h"

namespace pm {

namespace {

unsigned long long number(uint64_t value) {
    return static_cast<unsigned long long>(value);
}

std::vector<std::pair<std::string, uint64_t>> sections_of(const Header& h) {
    const Layout l(h);
    return {{"header", kHeaderSize},
            {"base_faces", l.root_split - l.base_faces},
            {"hierarchy", l.faces - l.root_split},
            {"faces", l.axis - l.faces},
            {"bounds", l.positions - l.axis},
            {"positions", l.normals - l.positions},
            {"normals", l.colours - l.normals},
            {"colours", l.welds - l.colours},
            {"welds", l.end - l.welds}};
}

std::string precision_of(const Header& h) {
    if (h.is_lossless()) return "single precision, as in the input";
    return core::text("%u bits, steps of %.3g", h.bits, h.placement.extent / h.steps());
}

}  // namespace

uint32_t Info::tree_bits() const {
    return uint32_t(std::bit_width(header.base_vertices - 1));
}

Info read_info(const Model& model) {
    Info info;
    info.name = model.name();
    info.header = model.header();
    info.file_bytes = model.size_bytes();
    info.sections = sections_of(info.header);
    const Hierarchy tree = model.hierarchy();
    uint64_t faces = info.header.base_faces;
    for (uint32_t d = 0; d < model.details(); ++d) {
        info.dependencies += tree.needs[d] != kNone;
        const bool is_boundary = tree.faces[d].left_cut() == kNone || tree.faces[d].right_cut() == kNone;
        info.boundary_splits += is_boundary;
        info.without_cone += model.cone(d).angle == kAnyDirection;
        faces += is_boundary ? 1 : 2;
        if (d == 0 || model.error_code(d) != model.error_code(d - 1)) info.levels.emplace_back();
        info.levels.back() = {decode_error(model.error_code(d)) * info.header.placement.extent, d + 1, faces};
    }
    return info;
}

std::string to_text(const Info& info) {
    const Header& h = info.header;
    std::string text = core::text("%s: progressive mesh, %llu bytes (%.2f a vertex)\n", info.name.c_str(),
                                  number(info.file_bytes), double(info.file_bytes) / double(h.vertices()));
    text += core::text("  fully refined   %llu vertices, %llu faces (input: %llu, %llu)\n",
                       number(h.vertices()), number(h.faces), number(h.vertices_in), number(h.triangles_in));
    text += core::text("  base mesh       %u vertices, %u faces\n", h.base_vertices, h.base_faces);
    text += core::text("  splits          %u, %llu at boundaries, %llu need one that is no ancestor\n",
                       h.details, number(info.boundary_splits), number(info.dependencies));
    text += core::text("  depth           %u; a node would be named by <%u, %u> bits\n", h.depth,
                       info.tree_bits(), info.node_bits());
    text += core::text("  positions       %s\n", precision_of(h).c_str());
    text += core::text("  surface         %s, %llu splits without a cone\n",
                       h.flags & kOpenSurface ? "open, both sides may be seen" : "closed but for small gaps",
                       number(info.without_cone));
    text += core::text("  cut vertices    %u\n", h.welds);
    for (const auto& [name, bytes] : info.sections)
        if (bytes > 0) text += core::text("  %-15s %llu bytes\n", name.c_str(), number(bytes));
    text += "  error           splits     faces\n";
    // Every fourth, a factor of 2 in error, and the last.
    for (size_t i = 0; i < info.levels.size(); ++i)
        if (const ErrorLevel& level = info.levels[i]; i % 4 == 0 || i + 1 == info.levels.size())
            text +=
                core::text("  %-12.3g %9llu %9llu\n", level.error, number(level.splits), number(level.faces));
    return text;
}

nlohmann::ordered_json to_json(const Info& info) {
    const Header& h = info.header;
    nlohmann::ordered_json json;
    json["file"] = info.name;
    json["format"] = "pm";
    json["file_bytes"] = info.file_bytes;
    json["hash"] = core::text("%016llx", number(model_hash(h)));
    json["vertices_in"] = h.vertices_in;
    json["triangles_in"] = h.triangles_in;
    json["vertices"] = h.vertices();
    json["faces"] = h.faces;
    json["base_vertices"] = h.base_vertices;
    json["base_faces"] = h.base_faces;
    json["details"] = h.details;
    json["boundary_splits"] = info.boundary_splits;
    json["dependencies"] = info.dependencies;
    json["depth"] = h.depth;
    json["tree_bits"] = info.tree_bits();
    json["node_bits"] = info.node_bits();
    json["bits"] = h.bits;
    json["is_closed"] = (h.flags & kOpenSurface) == 0;
    json["without_cone"] = info.without_cone;
    json["cut_vertices"] = h.welds;
    json["has_colours"] = h.has_colours();
    json["has_normals"] = h.has_normals();
    json["extent"] = h.placement.extent;
    for (const auto& [name, bytes] : info.sections) json["section_bytes"][name] = bytes;
    json["levels"] = nlohmann::ordered_json::array();
    for (const ErrorLevel& level : info.levels)
        json["levels"].push_back({{"error", level.error}, {"splits", level.splits}, {"faces", level.faces}});
    return json;
}

}  // namespace pm
