// The .qs file: constants, header and block layout.  The specification is man/qs.5; this follows it.
//
//     file  = header (256 bytes), zeros to byte 1024, then blocks of one size
//     block = header (16 bytes), then one array a channel, for `capacity` nodes:
//             u16 attitude[], u16 place[], u16 colour[] where there is colour, u4 shape[]
//
// Where leaves are triangles (kTriangles), block headers have 28 bytes, and the last blocks of the file hold
// the corners (triangle_run.h).
//
// Nodes stand in breadth-first order, whole sibling groups to a block.  Where a group's children
// are is not stored: each block says where the first child group of its nodes is, and the rest
// follows by counting (Model::children_of).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>

namespace splat {

constexpr char kMagic[8] = {'q', 's', '-', 'm', 'o', 'd', 'e', 'l'};
constexpr uint32_t kVersion = 2;  // the newest; files without triangles are of version 1
constexpr char kCodedMagic[8] = {'q', 's', '-', 'c', 'o', 'd', 'e', 'd'};  // compressed: coded_file.h
constexpr uint32_t kCodedVersion = 2;    // likewise: in version 1 blocks of triangles stand as they are
constexpr size_t kCodedHeaderSize = 24;  // then the header of the plain file
constexpr size_t kCodedFileSizeAt = 16;
constexpr size_t kHeaderSize = 256;
constexpr size_t kBlocksAt =
    1024;  // then zeros, so that a block of 1 KiB is one of qs-fetch's cache, not parts of two
constexpr int kMaxLatticeBits = 30;
constexpr uint32_t kMinBlockSize = 1024, kMaxBlockSize = 65536;
constexpr int kMaxFanOut = 7;     // three bits say "leaf, or 1 to 7 children"
constexpr int kMaxLevels = 4096;  // deeper files are refused

enum Flags : uint32_t {
    kHasColour = 1,       // u16 colour a node, 5:6:5, red in the high bits
    kConstantColour = 2,  // one colour for all, in the header
    kOpenSurface = 4,     // not closed: both sides may be seen, cones must not cull
    kCloud = 8,           // built from bare points: radii are estimates, `error` is to the points
    kTriangles = 16,      // leaves are triangles, whose corners stand in blocks of their own
};

// The root is not a node of the blocks: its sphere is the unit sphere of model space, and the rest
// of it stands here.  World = origin + scale * model.
struct Header {
    uint32_t block_size = kMinBlockSize;
    uint32_t flags = 0;
    glm::dvec3 origin{0};  // world position of the root's centre
    double scale = 1;      // world units in a model unit (the root's radius), > 0
    uint64_t block_count = 0;
    uint64_t node_count = 0;  // without the root
    uint64_t leaf_count = 0;
    uint64_t vertices_in = 0;  // of the input, dropped ones included
    uint64_t triangles_in = 0;
    uint32_t level_count = 0;    // levels below the root
    uint32_t root_children = 0;  // 1..7, at block 0, slot 0
    glm::vec3 root_normal{0, 0, 1};
    float root_flatness = 1;
    float root_error = 2;
    int32_t root_cone = -1;
    std::array<uint8_t, 4> colour{};  // with kConstantColour: r, g, b, 0; else the root's mean colour

    // With kTriangles: corners are integers times 2^-lattice_bits, in model units; how many of the blocks,
    // the last ones, hold them.  Else 0.
    uint32_t lattice_bits = 0;
    uint64_t triangle_blocks = 0;

    bool has_colour() const { return flags & kHasColour; }
    bool has_triangles() const { return flags & kTriangles; }
    uint32_t version() const { return has_triangles() ? 2 : 1; }
    uint64_t node_blocks() const { return block_count - triangle_blocks; }
    uint64_t triangle_payload() const { return block_size - sizeof(uint32_t); }  // bytes of runs in a block
    uint32_t block_header_size() const { return has_triangles() ? 28 : 16; }
    uint32_t capacity() const;  // nodes a block: as many as fit, a multiple of 7
    uint64_t block_at(uint64_t number) const { return kBlocksAt + number * block_size; }  // in the plain file
    uint64_t plain_bytes() const { return block_at(block_count); }                        // of the plain file
};

struct BlockHeader {
    uint32_t checksum;    // low half of XXH3_64bits_withSeed(bytes 4.., block number)
    uint16_t node_count;  // nodes used; the rest is zero
    uint16_t child_slot;  // where the first child group of the block's nodes is
    uint64_t child_block;
};
// Behind it with kTriangles: u64, where the first run of the block's leaves is, in bytes of all runs.
constexpr size_t kBlockTrianglesAt = sizeof(BlockHeader);
// And f32, the longest side of the middle one of its triangles, model units.
constexpr size_t kBlockMiddleSideAt = kBlockTrianglesAt + sizeof(uint64_t);

// A block of triangles is its checksum, as a node block's, and bytes of runs, which go on from block to
// block.
constexpr size_t kTriangleBlockHeader = sizeof(uint32_t);

// Serialised form, 256 bytes with its checksum.  parse throws core::Error "<name>: ..."; of a compressed
// model it takes the header of the plain one.  `bytes` are the file as far as it is there, and so much is
// checked of the gap, which no checksum covers.
std::array<std::byte, kHeaderSize> encode_header(const Header& header);
Header parse_header(std::span<const std::byte> bytes, const std::string& name);
constexpr std::array<std::byte, kBlocksAt - kHeaderSize> kGap{};  // between the header and block 0
// How long the file is that begins so: core::InputFile::SizeLimit.  Throws as parse_header.
uint64_t file_bytes(std::span<const std::byte> head, const std::string& name);
bool is_model(std::span<const std::byte> bytes);  // by the magic alone, plain or compressed
bool is_coded(std::span<const std::byte> bytes);  // compressed, likewise

// Byte offsets of the channels in a block.
struct BlockLayout {
    explicit BlockLayout(const Header& header);
    uint32_t capacity;
    size_t attitude, place, shape, colour;
};

uint32_t block_checksum(std::span<const std::byte> block, uint64_t number);

}  // namespace splat
