#include "splat/info.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/error.h"
#include "splat/triangle_reader.h"
#include "splat/walk.h"

namespace splat {

namespace {

unsigned long long number(uint64_t value) {
    return static_cast<unsigned long long>(value);
}

std::vector<std::string> left_out_of(const Header& h) {
    std::vector<std::string> left_out;
    if (h.flags & kConstantColour)
        left_out.push_back(core::text("colour: one for all, %d,%d,%d, in the header", h.colour[0],
                                      h.colour[1], h.colour[2]));
    else if (!h.has_colour())
        left_out.emplace_back("colour: the input had none, or it was not wanted");
    if (!h.has_triangles())
        left_out.emplace_back(h.flags & kCloud ? "triangles: the input had none"
                                               : "triangles: leaves are points");
    return left_out;
}

void finish_means(LevelInfo& level) {
    if (level.nodes == 0) return;
    level.radius_mean /= double(level.nodes);
    level.error_mean /= double(level.nodes);
}

const char* surface_of(const Header& h) {
    if (h.flags & kCloud) return "cloud";
    return h.flags & kOpenSurface ? "open" : "closed";
}

double per_vertex(const Info& info, uint64_t bytes) {
    return double(bytes) / double(std::max<uint64_t>(info.header.vertices_in, 1));
}

// 2.26 MiB
std::string size_text(uint64_t bytes) {
    const char* const units[] = {"bytes", "KiB", "MiB", "GiB", "TiB"};
    if (bytes < 1024) return core::text("%llu bytes", number(bytes));
    size_t unit = 0;
    double value = double(bytes);
    while (value >= 1024 && unit + 1 < std::size(units)) value /= 1024, ++unit;
    return core::text("%.3g %s", value >= 999.5 ? std::round(value) : value, units[unit]);
}

std::string levels_text(const Info& info) {
    std::string out =
        "level      nodes     leaves  radius mean   radius max   error mean    error max  prefix bytes\n";
    for (size_t l = 0; l < info.levels.size(); ++l) {
        const LevelInfo& level = info.levels[l];
        out += core::text("%5zu %10llu %10llu %12.5g %12.5g %12.5g %12.5g  %12llu%s\n", l,
                          number(level.nodes), number(level.leaves), level.radius_mean, level.radius_max,
                          level.error_mean, level.error_max, number(level.prefix_bytes),
                          l > info.levels_complete ? ", incomplete" : "");
    }
    return out;
}

}  // namespace

std::vector<ChannelInfo> channels_of(const Header& h, uint64_t file_bytes) {
    const auto bytes = [&](uint64_t bits) { return (h.node_count * bits + 7) / 8; };
    std::vector<ChannelInfo> channels{{"structure_and_cone", bytes(5)},
                                      {"normal", bytes(10)},
                                      {"sphere", bytes(16)},
                                      {"flatness_and_error", bytes(5)}};
    if (h.has_colour()) channels.push_back({"colour", bytes(16)});
    if (h.has_triangles()) channels.push_back({"triangles", h.triangle_blocks * h.block_size});
    channels.push_back({"headers", kHeaderSize + h.node_blocks() * h.block_header_size()});
    uint64_t used = 0;
    for (const ChannelInfo& c : channels) used += c.bytes;
    channels.push_back({"unused", file_bytes - std::min(used, file_bytes)});
    return channels;
}

namespace {

TriangleInfo read_triangles(const Model& model) {
    TriangleInfo info;
    BlockView nodes;
    BlockTriangles triangles;
    for (uint64_t b = 0; b < model.node_blocks_present(); ++b) {
        nodes.open(model, b);
        triangles.open(model, nodes);
        for (const BlockTriangles::PlacedRun& placed : triangles.runs()) {
            const TriangleRun& run = placed.run;
            ++info.runs;
            info.triangles += run.triangles(), info.corners += run.corners();
            if (run.has_normals()) info.corner_normals += run.corners();
            for (uint32_t t = 0; t < run.triangles(); ++t) info.smooth += run.is_smooth(t);
        }
    }
    return info;
}

}  // namespace

std::vector<ChannelInfo> channels_of(const Header& h, const CompressedSizes& sizes) {
    const auto bytes = [&](std::string_view channel) {
        double bits = 0;
        for (size_t f = 0; f < kSymbolFields.size(); ++f)
            if (channel == kSymbolFields[f].channel) bits += sizes.field_bits[f];
        return uint64_t(std::ceil(bits / 8));
    };
    std::vector<ChannelInfo> channels;
    for (const char* channel : {"structure_and_cone", "normal", "sphere", "flatness_and_error"})
        channels.push_back({channel, bytes(channel)});
    if (h.has_colour()) channels.push_back({"colour", bytes("colour")});
    if (h.has_triangles()) channels.push_back({"triangles", bytes("triangles")});
    if (sizes.blocks_as_they_are > 0)
        channels.push_back({"blocks_as_they_are", sizes.blocks_as_they_are * sizes.block_size});
    channels.push_back({"tables", sizes.table_bytes});
    channels.push_back({"index", sizes.index_bytes});
    uint64_t used = 0;
    for (const ChannelInfo& c : channels) used += c.bytes;
    channels.push_back({"headers", sizes.file_bytes - std::min(used, sizes.file_bytes)});
    return channels;
}

Info read_info(const Model& model) {
    const Header& h = model.header();
    Info info;
    info.name = model.name();
    info.header = h;
    info.plain_bytes = h.plain_bytes();
    info.is_compressed = model.coded() != nullptr;
    info.file_bytes = info.is_compressed ? model.coded()->file_size() : info.plain_bytes;
    info.bytes_present = model.size_bytes();
    info.blocks_present = model.blocks_present();
    info.levels_complete = h.level_count;
    if (!info.is_compressed)
        info.channels = channels_of(h, info.file_bytes);
    else if (model.is_complete())
        info.channels = channels_of(h, sizes_of(*model.coded()));
    info.left_out = left_out_of(h);
    if (h.has_triangles()) info.triangles = read_triangles(model);
    const auto add = [&](LevelInfo& level, const Node& node) {
        ++level.nodes;
        level.leaves += node.children == 0;
        const double radius = double(node.radius) * h.scale, error = double(node.error) * h.scale;
        level.radius_mean += radius, level.radius_max = std::max(level.radius_max, radius);
        level.error_mean += error, level.error_max = std::max(level.error_max, error);
    };
    // The root is in the header, but without a block behind it a header is no model.
    add(info.levels.emplace_back(), model.root());
    std::vector<uint64_t> last_blocks{0};  // with nodes of a level
    info.opened = 1;
    walk(model, kMaxLevels, [&](const WalkedNode& n) {
        if (n.level >= info.levels.size()) info.levels.emplace_back(), last_blocks.emplace_back();
        add(info.levels[n.level], n.node);
        last_blocks[n.level] = n.at.block;
        if (n.lacks_children) info.levels_complete = std::min(info.levels_complete, n.level);
        info.opened += n.node.children > 0 && !n.lacks_children;
        info.leaves_present += n.node.children == 0;
        info.inserted += n.node.children == 1;
        ++info.nodes_present;
    });
    for (size_t l = 0; l < info.levels.size(); ++l) {
        finish_means(info.levels[l]);
        info.levels[l].prefix_bytes = model.prefix_bytes(last_blocks[l]);
    }
    return info;
}

std::string to_text(const Info& info) {
    const Header& h = info.header;
    std::string out = info.name + "\n";
    const auto line = [&](const char* what, const std::string& value) {
        out += core::text("%-12s ", what) + value + "\n";
    };
    line("vertices", core::text("%llu", number(h.vertices_in)));
    line("triangles", core::text("%llu", number(h.triangles_in)));
    line("leaves", core::text("%llu", number(h.leaf_count)));
    line("nodes", core::text("%llu (%llu inserted%s), fan-out %.2f", number(h.node_count),
                             number(info.inserted), info.is_complete() ? "" : " so far", info.fan_out()));
    line("levels", core::text("%u", h.level_count));
    line("surface", surface_of(h));
    if (h.has_triangles()) {
        const TriangleInfo& t = info.triangles;
        const double each = double(std::max<uint64_t>(t.triangles, 1));
        line("leaves are",
             core::text("triangles, %llu of them smooth, in runs of %.1f with %.3f corners a triangle",
                        number(t.smooth), each / double(std::max<uint64_t>(t.runs, 1)),
                        double(t.corners) / each));
        line("lattice",
             core::text("%u bits, step %.5g", h.lattice_bits, std::ldexp(h.scale, -int(h.lattice_bits))));
    }
    line("origin", core::text("%.17g %.17g %.17g", h.origin.x, h.origin.y, h.origin.z));
    line("scale", core::text("%.9g (radius of the root)", h.scale));
    line("blocks", core::text("%llu of %u bytes", number(h.block_count), h.block_size));
    if (info.is_compressed)
        line("compressed", core::text("yes, %.1f %% of %llu bytes",
                                      100.0 * double(info.file_bytes) / double(info.plain_bytes),
                                      number(info.plain_bytes)));
    line("file", size_text(info.file_bytes) +
                     core::text(" (%llu bytes), %.3f bytes a vertex", number(info.file_bytes),
                                per_vertex(info, info.file_bytes)) +
                     (h.has_triangles()
                          ? core::text(", %.3f a triangle", double(info.file_bytes) / double(h.leaf_count))
                          : ""));
    if (info.is_complete())
        line("complete", "yes");
    else
        line("complete", core::text("no: %llu of %llu blocks (%.1f %%), %llu of %llu nodes, levels 0 to %u",
                                    number(info.blocks_present), number(h.block_count),
                                    100.0 * double(info.blocks_present) / double(h.block_count),
                                    number(info.nodes_present), number(h.node_count), info.levels_complete));
    for (const ChannelInfo& c : info.channels)
        line("channel", core::text("%-20s %12llu bytes %7.3f a vertex", c.name.c_str(), number(c.bytes),
                                   per_vertex(info, c.bytes)));
    for (const std::string& what : info.left_out) line("left out", what);
    return out + levels_text(info);
}

nlohmann::ordered_json to_json(const Info& info) {
    const Header& h = info.header;
    nlohmann::ordered_json json;
    json["file"] = info.name;
    json["version"] = h.version();
    json["vertices_in"] = h.vertices_in;
    json["triangles_in"] = h.triangles_in;
    json["leaves"] = h.leaf_count;
    json["nodes"] = h.node_count;
    json["nodes_inserted"] = info.inserted;
    json["fan_out_mean"] = info.fan_out();
    json["level_count"] = h.level_count;
    json["surface"] = surface_of(h);
    json["leaf"] = h.has_triangles() ? "triangle" : "point";
    if (h.has_triangles()) {
        const TriangleInfo& t = info.triangles;
        json["lattice_bits"] = h.lattice_bits;
        json["lattice_step"] = std::ldexp(h.scale, -int(h.lattice_bits));
        json["triangles_present"] = t.triangles;
        json["triangles_smooth"] = t.smooth;
        json["triangle_runs"] = t.runs;
        json["corners"] = t.corners;
        json["corner_normals"] = t.corner_normals;
        json["bytes_per_triangle"] = double(info.file_bytes) / double(h.leaf_count);
    }
    json["origin"] = {h.origin.x, h.origin.y, h.origin.z};
    json["scale"] = h.scale;
    json["blocks"] = h.block_count;
    json["block_bytes"] = h.block_size;
    json["file_bytes"] = info.file_bytes;
    json["is_compressed"] = info.is_compressed;
    json["plain_bytes"] = info.plain_bytes;
    json["bytes_per_vertex"] = per_vertex(info, info.file_bytes);
    json["is_complete"] = info.is_complete();
    json["bytes_present"] = info.bytes_present;
    json["blocks_present"] = info.blocks_present;
    json["blocks_present_percent"] = 100.0 * double(info.blocks_present) / double(h.block_count);
    json["nodes_present"] = info.nodes_present;
    json["leaves_present"] = info.leaves_present;
    json["levels_complete"] = info.levels_complete;
    for (const ChannelInfo& c : info.channels)
        json["channels"][c.name] = {{"bytes", c.bytes}, {"bytes_per_vertex", per_vertex(info, c.bytes)}};
    json["left_out"] = info.left_out;
    json["levels"] = nlohmann::ordered_json::array();
    for (size_t l = 0; l < info.levels.size(); ++l) {
        const LevelInfo& level = info.levels[l];
        json["levels"].push_back({{"level", l},
                                  {"nodes", level.nodes},
                                  {"leaves", level.leaves},
                                  {"radius_mean", level.radius_mean},
                                  {"radius_max", level.radius_max},
                                  {"error_mean", level.error_mean},
                                  {"error_max", level.error_max},
                                  {"prefix_bytes", level.prefix_bytes},
                                  {"is_complete", l <= info.levels_complete}});
    }
    return json;
}

}  // namespace splat
