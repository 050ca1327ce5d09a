#include "splat/format.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/bytes.h"
#include "core/error.h"
#include "core/file_kind.h"
#include "splat/node.h"

namespace splat {

namespace {

constexpr size_t kHeaderChecksumAt = kHeaderSize - 8;

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
    throw core::Error(name + ": header: " + what);
}

void check_layout(const Header& h, const std::string& name) {
    if (h.block_size < kMinBlockSize || h.block_size > kMaxBlockSize || !std::has_single_bit(h.block_size))
        refuse(name, core::text("block size %u is not a power of two from %u to %u", h.block_size,
                                kMinBlockSize, kMaxBlockSize));
    if (h.root_children < 1 || h.root_children > kMaxFanOut)
        refuse(name,
               core::text("the root has %u children, 1 to %d are possible", h.root_children, kMaxFanOut));
    if (h.block_count == 0 || h.block_count > (uint64_t(1) << 46) / h.block_size)
        refuse(name, core::text("block count %llu is out of range",
                                static_cast<unsigned long long>(h.block_count)));
    if (h.triangle_blocks >= h.block_count || h.has_triangles() != (h.triangle_blocks > 0))
        refuse(name, core::text("%llu of %llu blocks for triangles",
                                static_cast<unsigned long long>(h.triangle_blocks),
                                static_cast<unsigned long long>(h.block_count)));
    if (h.lattice_bits > kMaxLatticeBits || h.has_triangles() != (h.lattice_bits > 0))
        refuse(name, core::text("a lattice of %u bits", h.lattice_bits));
    if (h.node_count < h.root_children || h.node_count > h.node_blocks() * h.capacity() ||
        h.leaf_count > h.node_count || h.leaf_count == 0)
        refuse(name, core::text("%llu nodes with %llu leaves do not go with %llu blocks",
                                static_cast<unsigned long long>(h.node_count),
                                static_cast<unsigned long long>(h.leaf_count),
                                static_cast<unsigned long long>(h.block_count)));
    if (h.level_count < 1 || h.level_count > kMaxLevels)
        refuse(name, core::text("%u levels, 1 to %d are possible", h.level_count, kMaxLevels));
    if ((h.flags & kHasColour) && (h.flags & kConstantColour))
        refuse(name, "one colour for all, and one for each node");
    if ((h.flags & kCloud) && h.has_triangles()) refuse(name, "triangles of bare points");
}

void check_root(const Header& h, const std::string& name) {
    if (!(std::isfinite(h.origin.x) && std::isfinite(h.origin.y) && std::isfinite(h.origin.z)))
        refuse(name, "the origin is not finite");
    if (!(std::isfinite(h.scale) && h.scale > 0)) refuse(name, "the scale is not a positive number");
    const double length = glm::length(glm::dvec3(h.root_normal));
    if (!(std::fabs(length - 1) < 1e-3)) refuse(name, "the root's normal is not of unit length");
    if (!(h.root_flatness > 0 && h.root_flatness <= 1)) refuse(name, "the root's flatness is not in (0, 1]");
    if (!(h.root_error >= 0 && h.root_error <= 2)) refuse(name, "the root's error is not in [0, 2]");
    if (h.root_cone < -1 || h.root_cone >= kConeCount) refuse(name, "the root's cone is out of range");
}

[[noreturn]] void refuse_other_kind(std::span<const std::byte> bytes, const std::string& name) {
    using enum core::FileKind;
    const core::FileKind kind = core::file_kind(bytes);
    const bool can_become_one = kind == ply || kind == draco || kind == qsplat_model;
    throw core::Error(name + ": " + core::is_not_wanted(bytes, "a splat model", {kMagic, sizeof(kMagic)}) +
                      (can_become_one ? "; qs-build makes one of it" : ""));
}

void check_gap(std::span<const std::byte> bytes, const std::string& name) {
    for (size_t at = kHeaderSize; at < std::min(bytes.size(), kBlocksAt); ++at)
        if (bytes[at] != std::byte{0})
            refuse(name, core::text("byte %zu is not 0, as all before the blocks are", at));
}

}  // namespace

uint32_t Header::capacity() const {
    const uint32_t bits = has_colour() ? 52 : 36;
    const uint32_t nodes = (block_size - block_header_size()) * 8 / bits;
    return nodes / kMaxFanOut * kMaxFanOut;
}

BlockLayout::BlockLayout(const Header& header) : capacity(header.capacity()) {
    attitude = header.block_header_size();
    place = attitude + size_t(2) * capacity;
    colour = place + size_t(2) * capacity;
    shape = colour + (header.has_colour() ? size_t(2) * capacity : 0);
}

std::array<std::byte, kHeaderSize> encode_header(const Header& h) {
    core::ByteWriter w;
    for (const char c : kMagic) w.put(c);
    w.put(h.version());
    w.put(uint32_t(kBlocksAt));
    w.put(h.block_size);
    w.put(h.flags);
    w.put(h.origin.x), w.put(h.origin.y), w.put(h.origin.z);
    w.put(h.scale);
    w.put(h.block_count);
    w.put(h.node_count);
    w.put(h.leaf_count);
    w.put(h.vertices_in);
    w.put(h.triangles_in);
    w.put(h.level_count);
    w.put(h.root_children);
    w.put(h.root_normal.x), w.put(h.root_normal.y), w.put(h.root_normal.z);
    w.put(h.root_flatness);
    w.put(h.root_error);
    w.put(h.root_cone);
    for (const uint8_t c : h.colour) w.put(c);
    w.put(h.lattice_bits);
    w.put(h.triangle_blocks);
    std::array<std::byte, kHeaderSize> bytes{};
    std::memcpy(bytes.data(), w.bytes.data(), w.bytes.size());
    const uint64_t sum = XXH3_64bits(bytes.data(), kHeaderChecksumAt);
    std::memcpy(bytes.data() + kHeaderChecksumAt, &sum, sizeof(sum));
    return bytes;
}

namespace {

bool begins_with(std::span<const std::byte> bytes, const char (&magic)[8]) {
    return bytes.size() >= sizeof(magic) && std::memcmp(bytes.data(), magic, sizeof(magic)) == 0;
}

}  // namespace

bool is_model(std::span<const std::byte> bytes) {
    return begins_with(bytes, kMagic) || is_coded(bytes);
}
bool is_coded(std::span<const std::byte> bytes) {
    return begins_with(bytes, kCodedMagic);
}

uint64_t file_bytes(std::span<const std::byte> head, const std::string& name) {
    const Header header = parse_header(head, name);
    if (!is_coded(head)) return header.plain_bytes();
    uint64_t bytes;
    std::memcpy(&bytes, head.data() + kCodedFileSizeAt, sizeof(bytes));
    return bytes;
}

Header parse_header(std::span<const std::byte> bytes, const std::string& name) {
    if (is_coded(bytes)) {
        if (bytes.size() < kCodedHeaderSize + kHeaderSize)
            throw core::Error(core::text("%s: cut off at byte %zu, before the end of its header",
                                         name.c_str(), bytes.size()));
        return parse_header(bytes.subspan(kCodedHeaderSize, kHeaderSize), name);
    }
    if (!is_model(bytes)) refuse_other_kind(bytes, name);
    if (bytes.size() < kHeaderSize)
        throw core::Error(core::text("%s: cut off at byte %zu, the header has %zu", name.c_str(),
                                     bytes.size(), kHeaderSize));
    core::ByteReader r(bytes, name);
    r.take<uint64_t>();
    const auto version = r.take<uint32_t>();
    if (version < 1 || version > kVersion)
        throw core::Error(core::text("%s: format version %u, this program reads versions 1 to %u",
                                     name.c_str(), version, kVersion));
    uint64_t sum;
    std::memcpy(&sum, bytes.data() + kHeaderChecksumAt, sizeof(sum));
    const uint64_t found = XXH3_64bits(bytes.data(), kHeaderChecksumAt);
    if (sum != found) refuse(name, core::wrong_checksum(found, sum, 16));
    if (const auto at = r.take<uint32_t>(); at != kBlocksAt)
        refuse(name, core::text("blocks from byte %u on, version %u has them from %zu on; build the model "
                                "again with qs-build",
                                at, version, kBlocksAt));
    Header h;
    h.block_size = r.take<uint32_t>();
    h.flags = r.take<uint32_t>();
    h.origin.x = r.take<double>(), h.origin.y = r.take<double>(), h.origin.z = r.take<double>();
    h.scale = r.take<double>();
    h.block_count = r.take<uint64_t>();
    h.node_count = r.take<uint64_t>();
    h.leaf_count = r.take<uint64_t>();
    h.vertices_in = r.take<uint64_t>();
    h.triangles_in = r.take<uint64_t>();
    h.level_count = r.take<uint32_t>();
    h.root_children = r.take<uint32_t>();
    h.root_normal.x = r.take<float>(), h.root_normal.y = r.take<float>(), h.root_normal.z = r.take<float>();
    h.root_flatness = r.take<float>();
    h.root_error = r.take<float>();
    h.root_cone = r.take<int32_t>();
    for (uint8_t& c : h.colour) c = r.take<uint8_t>();
    // Version 1 reserves what comes now, and its readers do not look there.
    if (version > 1) {
        h.lattice_bits = r.take<uint32_t>();
        h.triangle_blocks = r.take<uint64_t>();
    }
    if (h.version() > version) refuse(name, core::text("flags %08x are not of version %u", h.flags, version));
    check_layout(h, name);
    check_root(h, name);
    check_gap(bytes, name);
    return h;
}

uint32_t block_checksum(std::span<const std::byte> block, uint64_t number) {
    return uint32_t(XXH3_64bits_withSeed(block.data() + 4, block.size() - 4, number));
}

}  // namespace splat
