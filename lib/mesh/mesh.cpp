#include "mesh/mesh.h"

#include <algorithm>
#include <cctype>
#include <cstring>

#include "core/error.h"
#include "core/file.h"
#include "core/file_kind.h"
#include "mesh/draco.h"
#include "mesh/obj.h"
#include "mesh/off.h"
#include "mesh/ply.h"
#include "mesh/qsplat.h"
#include "mesh/reader.h"
#include "mesh/stl.h"
#include "mesh/text.h"

namespace mesh {

namespace {

// The first word of the text, after comments.
std::string_view first_word(const Source& source) {
    return TextReader(source, 0, '#').word();
}

bool has_extension(const Source& source, std::string_view extension) {
    const std::string& name = source.name;
    return name.size() > extension.size() &&
           std::equal(extension.rbegin(), extension.rend(), name.rbegin(),
                      [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

// What is often tried, and is none of the forms that are read; empty for anything else.
std::string foreign_form(std::span<const std::byte> bytes) {
    using enum core::FileKind;
    const core::FileKind kind = core::file_kind(bytes);
    if (kind == unknown) return {};
    const std::string name(core::name_of(kind));
    switch (kind) {
        case las:
        case e57:
            return name + ", which is not read; make it PLY first, as 'pdal translate INPUT OUTPUT.ply' does";
        case splat_model:
        case progressive_mesh:
            return name + " already; what it was made of is wanted";
        case volume:
            return name + ", which ppve-sample draws, and nothing else";
        default:
            return name + ", which is neither a mesh nor a cloud of points that is read";
    }
}

ReadResult read_source(const Source& source, const ReadOptions& options) {
    const std::string_view text = source.text();
    if (text.empty()) throw core::Error(source.name + ": the file is empty");
    if (text.starts_with("ply")) return read_ply(source, options);
    if (text.starts_with("DRACO")) return read_draco(source, options);
    if (is_qsplat(source)) return read_qsplat(source, options);
    if (is_off_keyword(first_word(source))) return read_off(source, options);
    // A binary STL may begin with anything.
    if (is_binary_stl(source)) return read_stl(source, options);
    if (has_extension(source, ".ply")) return read_ply(source, options);
    if (has_extension(source, ".drc")) return read_draco(source, options);
    if (has_extension(source, ".obj")) return read_obj(source, options);
    if (has_extension(source, ".off")) return read_off(source, options);
    if (has_extension(source, ".stl") || text.starts_with("solid")) return read_stl(source, options);
    if (is_obj_keyword(first_word(source))) return read_obj(source, options);
    if (const std::string form = foreign_form(source.bytes); !form.empty())
        throw core::Error(source.name + ": " + form);
    throw core::Error(source.name + ": header: neither PLY, OBJ, OFF, STL, Draco nor QSplat");
}

template <class T>
void append(std::string& out, const T& value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    out.append(bytes, sizeof(T));
}

void append_properties(std::string& out, const char* type, const char* x, const char* y, const char* z) {
    for (const char* name : {x, y, z}) out += core::text("property %s %s\n", type, name);
}

}  // namespace

ReadResult read_mesh(const std::string& path, const ReadOptions& options) {
    return read_mesh(core::InputFile(path), options);
}

ReadResult read_mesh(core::InputFile file, const ReadOptions& options) {
    return read_source({file.bytes(), file.name(), &file}, options);
}

ReadResult read_mesh_bytes(std::span<const std::byte> bytes, const std::string& name,
                           const ReadOptions& options) {
    return read_source({bytes, name, nullptr}, options);
}

std::string to_ply(const Mesh& mesh) {
    const bool is_double = mesh.origin != glm::dvec3(0);
    std::string out = "ply\nformat binary_little_endian 1.0\n";
    out += core::text("element vertex %zu\n", mesh.positions.size());
    append_properties(out, is_double ? "double" : "float", "x", "y", "z");
    if (!mesh.normals.empty()) append_properties(out, "float", "nx", "ny", "nz");
    if (!mesh.colours.empty()) append_properties(out, "uchar", "red", "green", "blue");
    if (!mesh.radii.empty()) out += "property float radius\n";
    if (!mesh.is_cloud())
        out +=
            core::text("element face %zu\nproperty list uchar uint vertex_indices\n", mesh.triangles.size());
    out += "end_header\n";

    const size_t vertex_bytes = (is_double ? 24 : 12) + (mesh.normals.empty() ? 0 : 12) +
                                (mesh.colours.empty() ? 0 : 3) + (mesh.radii.empty() ? 0 : 4);
    out.reserve(out.size() + mesh.positions.size() * vertex_bytes + mesh.triangles.size() * 13);
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        if (is_double)
            append(out, mesh.world(v));
        else
            append(out, mesh.positions[v]);
        if (!mesh.normals.empty()) append(out, mesh.normals[v]);
        if (!mesh.colours.empty()) append(out, mesh.colours[v]);
        if (!mesh.radii.empty()) append(out, mesh.radii[v]);
    }
    for (const glm::u32vec3& t : mesh.triangles) {
        out += '\3';
        append(out, t);
    }
    return out;
}

}  // namespace mesh
