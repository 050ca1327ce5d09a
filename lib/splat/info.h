// What a model, or a prefix of one, holds: counts, levels and their errors, bytes by channel.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "splat/compress.h"
#include "splat/model.h"

namespace splat {

// The nodes of one level that are there.  Radii and errors in world units.
struct LevelInfo {
    uint64_t nodes = 0, leaves = 0;
    double radius_mean = 0, radius_max = 0;
    double error_mean = 0, error_max = 0;
    uint64_t prefix_bytes = 0;  // to the end of the block with its last node: a prefix that shows it whole
};

struct ChannelInfo {
    std::string name;
    uint64_t bytes;  // of the whole file, rounded up
};

// What each channel takes, and the blocks' headers and unused ends ("triangles": their blocks, as a whole).
std::vector<ChannelInfo> channels_of(const Header& h, uint64_t file_bytes);
std::vector<ChannelInfo> channels_of(const Header& h, const CompressedSizes& sizes);

// Of leaves that are triangles, as far as their blocks are there.
struct TriangleInfo {
    uint64_t triangles = 0, smooth = 0, runs = 0;
    uint64_t corners = 0;         // entries of the runs' tables
    uint64_t corner_normals = 0;  // entries with normals
};

struct Info {
    std::string name;
    Header header;
    uint64_t file_bytes = 0;   // of the whole file
    uint64_t plain_bytes = 0;  // likewise, without compression
    bool is_compressed = false;
    uint64_t bytes_present = 0;
    uint64_t blocks_present = 0;
    uint64_t nodes_present = 0, leaves_present = 0;
    uint64_t opened = 0;    // nodes whose children are there, with the root
    uint64_t inserted = 0;  // nodes with one child, between a large parent and a small child
    uint32_t levels_complete = 0;
    TriangleInfo triangles;
    std::vector<LevelInfo> levels;      // [0] is the root; the last may be incomplete
    std::vector<ChannelInfo> channels;  // they add up to file_bytes
    std::vector<std::string> left_out;  // "colour: none", ...

    bool is_complete() const { return blocks_present == header.block_count; }
    double fan_out() const { return double(nodes_present) / double(opened); }  // mean, of those opened
};

// Reads every block that is there.  Throws core::Error for a damaged one, as walk() does.
Info read_info(const Model& model);

std::string to_text(const Info& info);             // lines, for people
nlohmann::ordered_json to_json(const Info& info);  // keys as in qs-info(1)

}  // namespace splat
