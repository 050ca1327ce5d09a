#include "pm/format.h"

#include <xxhash.h>

#include <cmath>
#include <cstring>

#include "core/bytes.h"
#include "core/error.h"
#include "core/file_kind.h"

namespace pm {

namespace {

constexpr size_t kChecksumAt = kHeaderSize - 8;
constexpr size_t kReservedAt = 136;

unsigned long long number(uint64_t value) {
    return static_cast<unsigned long long>(value);
}

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
    throw core::Error(name + ": header: " + what);
}

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check_counts(const Header& h, const std::string& name) {
    if (h.base_vertices == 0) refuse(name, "the base mesh has no vertices");
    if (h.vertices() > kMostVertices)
        refuse(name,
               core::text("%llu vertices, at most %u are possible", number(h.vertices()), kMostVertices));
    // Every split adds one face or two.
    if (h.faces < uint64_t(h.base_faces) + h.details ||
        h.faces > uint64_t(h.base_faces) + 2 * uint64_t(h.details))
        refuse(name, core::text("%u faces of the base mesh and %u splits do not make %llu faces",
                                h.base_faces, h.details, number(h.faces)));
    if (h.depth > h.details || (h.depth == 0) != (h.details == 0))
        refuse(name, core::text("a depth of %u with %u splits", h.depth, h.details));
    if (h.welds > h.vertices())
        refuse(name, core::text("%u welds of %llu vertices", h.welds, number(h.vertices())));
}

void check_values(const Header& h, const std::string& name) {
    constexpr uint32_t kKnown = kHasColours | kHasNormals | kOpenSurface;
    if (h.flags & ~kKnown) refuse(name, core::text("unknown flags %08x", h.flags & ~kKnown));
    if (h.bits != 0 && (h.bits < kMinBits || h.bits > kMaxBits))
        refuse(name,
               core::text("%u bits a coordinate, %u to %u are possible, or 0", h.bits, kMinBits, kMaxBits));
    if (!is_finite(h.placement.origin) || !is_finite(h.placement.low))
        refuse(name, "the origin is not finite");
    if (!(std::isfinite(h.placement.extent) && h.placement.extent > 0))
        refuse(name, "the extent is not a positive number");
}

}  // namespace

Layout::Layout(const Header& h) {
    const uint64_t n = h.details, v = h.vertices();
    uint64_t to = kHeaderSize;
    const auto place = [&](uint64_t bytes) {
        const uint64_t from = to;
        to += (bytes + 7) / 8 * 8;
        return from;
    };
    base_faces = place(uint64_t(12) * h.base_faces);
    root_split = place(uint64_t(4) * h.base_vertices);
    kept = place(4 * n);
    parent = place(4 * n);
    needs = place(4 * n);
    children = place(8 * n);
    faces = place(24 * n);
    axis = place(2 * n);
    angle = place(n);
    error = place(n);
    radius = place(n);
    positions = place(h.position_bytes() * v);
    normals = place(h.has_normals() ? 2 * v : 0);
    colours = place(h.has_colours() ? 3 * v : 0);
    welds = place(uint64_t(8) * h.welds);
    end = to;
}

std::array<std::byte, kHeaderSize> encode_header(const Header& h) {
    core::ByteWriter w;
    for (const char c : kMagic) w.put(c);
    w.put(kVersion);
    w.put(uint32_t(kHeaderSize));
    for (const uint32_t value :
         {h.flags, h.bits, h.base_vertices, h.base_faces, h.details, h.welds, h.depth, 0u})
        w.put(value);
    for (const uint64_t value : {h.faces, h.vertices_in, h.triangles_in}) w.put(value);
    for (const glm::dvec3& v : {h.placement.origin, h.placement.low}) w.put(v.x), w.put(v.y), w.put(v.z);
    w.put(h.placement.extent);
    w.put(h.content_hash);
    std::array<std::byte, kHeaderSize> bytes{};
    std::memcpy(bytes.data(), w.bytes.data(), w.bytes.size());
    const uint64_t sum = XXH3_64bits(bytes.data(), kChecksumAt);
    std::memcpy(bytes.data() + kChecksumAt, &sum, sizeof(sum));
    return bytes;
}

bool is_model(std::span<const std::byte> bytes) {
    return bytes.size() >= sizeof(kMagic) && std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) == 0;
}

Header parse_header(std::span<const std::byte> bytes, const std::string& name) {
    if (!is_model(bytes))
        throw core::Error(name + ": " + core::is_not_wanted(bytes, "a progressive mesh", "qspmesh"));
    if (bytes.size() < kHeaderSize)
        throw core::Error(core::text("%s: cut off at byte %zu, the header has %zu", name.c_str(),
                                     bytes.size(), kHeaderSize));
    core::ByteReader r(bytes, name);
    r.take<uint64_t>();
    if (const auto version = r.take<uint32_t>(); version != kVersion)
        throw core::Error(core::text("%s: format version %u, this program reads version %u", name.c_str(),
                                     version, kVersion));
    uint64_t sum;
    std::memcpy(&sum, bytes.data() + kChecksumAt, sizeof(sum));
    if (const uint64_t found = XXH3_64bits(bytes.data(), kChecksumAt); sum != found)
        refuse(name, core::wrong_checksum(found, sum, 16));
    if (const auto size = r.take<uint32_t>(); size != kHeaderSize)
        refuse(name, core::text("size %u, version %u has %zu", size, kVersion, kHeaderSize));
    Header h;
    for (uint32_t* value :
         {&h.flags, &h.bits, &h.base_vertices, &h.base_faces, &h.details, &h.welds, &h.depth})
        *value = r.take<uint32_t>();
    bool is_reserved_zero = r.take<uint32_t>() == 0;
    for (uint64_t* value : {&h.faces, &h.vertices_in, &h.triangles_in}) *value = r.take<uint64_t>();
    for (glm::dvec3* v : {&h.placement.origin, &h.placement.low})
        for (int i = 0; i < 3; ++i) (*v)[i] = r.take<double>();
    h.placement.extent = r.take<double>();
    h.content_hash = r.take<uint64_t>();
    for (size_t i = kReservedAt; i < kChecksumAt; ++i)
        is_reserved_zero = is_reserved_zero && bytes[i] == std::byte{0};
    if (!is_reserved_zero) refuse(name, "what is reserved is not 0");
    check_values(h, name);
    check_counts(h, name);
    return h;
}

uint64_t model_hash(const Header& header) {
    const auto bytes = encode_header(header);
    uint64_t sum;
    std::memcpy(&sum, bytes.data() + kChecksumAt, sizeof(sum));
    return sum;
}

}  // namespace pm
