// The .pm file: constants and header.  The specification is man/pm.5; this follows it.
//
//     file = header (192 bytes), then the sections below, in this order, each padded with zeros to 8 bytes:
//
//     base_faces   u32[3]  a face of the base mesh: its leaf corners, as vertex numbers
//     root_split   u32     by base vertex: the detail that splits it, or kNone
//     kept         u32     by detail: the vertex that it splits, and which it keeps
//     parent       u32     by detail: the detail that made the node which this one splits, or kNone: a root
//     needs        u32     by detail: a detail that must be split before, and is no ancestor; or kNone
//     children     u32[2]  by detail: the details that split its kept and its new child, or kNone: a leaf
//     faces        u32[6]  by detail: leaf corners of the left and of the right face that it adds, or kNone
//     thrice axis         u16     by detail, as the next three: cone of normals below the node that it splits
//     (cone.h) angle        u8 error        u8      (bounds.h) radius       u8 positions    by vertex: u16[3]
//     (bits <= 16), u32[3] (bits <= 24), or f32[3] (bits 0: lossless) normals      u16     by vertex, with
//     kHasNormals (cone.h) colours      u8[3]   by vertex, with kHasColours: sRGB welds        u32[2]  a
//     vertex and the one that it was cut off from: welded again, they are one
//
// Vertices: 0 .. base_vertices - 1 are the base mesh's, base_vertices + d is born by detail d.
// Details stand in the order of falling error; what a detail depends on stands before it.  So every prefix
// of them is a legal mesh, the best of its size that the file has.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>

namespace pm {

constexpr char kMagic[8] = {'q', 's', 'p', 'm', 'e', 's', 'h', '\n'};
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderSize = 192;
constexpr uint32_t kNone = 0xffffffff;
constexpr uint32_t kMostVertices = 0x7fffffff;
constexpr uint32_t kMinBits = 4, kMaxBits = 24, kDefaultBits = 14;

enum Flags : uint32_t {
    kHasColours = 1,
    kHasNormals = 2,
    kOpenSurface = 4,  // both sides may be seen: no cone culls
};

// From unit space, in which the model's box lies in [0, 1]^3 with its longest side 1 long, to the world.
struct Placement {
    glm::dvec3 origin{0};  // world position = origin + local position
    glm::dvec3 low{0};     // the box's lowest corner, local
    double extent = 1;     // the box's longest side, world units, > 0

    glm::dvec3 unit_from_world(const glm::dvec3& p) const { return ((p - origin) - low) / extent; }
    glm::dvec3 world_from_unit(const glm::dvec3& p) const { return origin + (low + p * extent); }
};

struct Header {
    uint32_t flags = 0;
    uint32_t bits = kDefaultBits;  // a coordinate; 0: lossless, as the input's single precision
    uint32_t base_vertices = 0, base_faces = 0;
    uint32_t details = 0;
    uint32_t welds = 0;
    uint32_t depth = 0;                          // splits on the longest way from a root to a leaf
    uint64_t faces = 0;                          // of the fully refined mesh
    uint64_t vertices_in = 0, triangles_in = 0;  // of the input, dropped ones included
    Placement placement;
    uint64_t content_hash = 0;  // XXH3 of all bytes behind the header

    bool is_lossless() const { return bits == 0; }
    bool has_colours() const { return flags & kHasColours; }
    bool has_normals() const { return flags & kHasNormals; }
    uint64_t vertices() const { return uint64_t(base_vertices) + details; }
    size_t position_bytes() const { return bits == 0 || bits > 16 ? 12 : 6; }
    double steps() const {
        return double((uint64_t(1) << bits) - 1);
    }  // of the lattice, along the longest side
};

// Byte offsets of the sections; `end` is the size of the file.
struct Layout {
    explicit Layout(const Header& header);
    uint64_t base_faces, root_split, kept, parent, needs, children, faces, axis, angle, error, radius,
        positions, normals, colours, welds, end;
};

// Serialised form, with its checksum in the last 8 bytes.  That checksum covers content_hash, so it stands
// for the whole file: model_hash().  parse throws core::Error "<name>: header: ...".
std::array<std::byte, kHeaderSize> encode_header(const Header& header);
Header parse_header(std::span<const std::byte> bytes, const std::string& name);
uint64_t model_hash(const Header& header);
bool is_model(std::span<const std::byte> bytes);  // by the magic alone

}  // namespace pm
