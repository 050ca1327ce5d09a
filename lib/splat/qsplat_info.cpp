#include "splat/qsplat_info.h"

#include <algorithm>
#include <sstream>

#include "core/error.h"

namespace splat {

namespace {

mesh::Source source_of(const core::InputFile& file) {
    return {file.bytes(), file.name(), &file};
}

unsigned long long number(uint64_t value) {
    return static_cast<unsigned long long>(value);
}

double per_leaf(const QsplatInfo& info) {
    return double(info.file_bytes) / double(std::max<uint64_t>(info.leaves, 1));
}

// Nodes of a group are its parent's children.
double fan_out(const QsplatInfo& info) {
    const uint64_t inner = info.nodes - info.leaves + info.file.fragments.size();
    return double(info.nodes) / double(inner);
}

void add_root(QsplatInfo& info, const mesh::QsplatFragment& fragment) {
    QsplatLevel& top = info.levels[0];
    ++top.nodes;
    top.radius_mean += double(fragment.root.radius);
    top.radius_max = std::max(top.radius_max, double(fragment.root.radius));
    info.nodes += fragment.nodes, info.leaves += fragment.leaves, info.pointers += fragment.pointers;
    info.has_colour |= fragment.has_colour;
}

}  // namespace

QsplatInfo read_qsplat_info(const core::InputFile& file) {
    QsplatInfo info;
    info.name = file.name();
    info.file_bytes = file.bytes().size();
    info.levels.emplace_back();
    info.file = mesh::walk_qsplat(source_of(file), [&](const mesh::QsplatNode& node) {
        if (node.level >= info.levels.size()) info.levels.resize(node.level + 1);
        QsplatLevel& level = info.levels[node.level];
        ++level.nodes;
        level.leaves += node.children == 0;
        level.radius_mean += double(node.sphere.radius);
        level.radius_max = std::max(level.radius_max, double(node.sphere.radius));
    });
    for (const mesh::QsplatFragment& fragment : info.file.fragments) add_root(info, fragment);
    for (QsplatLevel& level : info.levels) level.radius_mean /= double(level.nodes);
    return info;
}

std::string to_text(const QsplatInfo& info) {
    std::string out = info.name + "\n", text;
    const auto line = [&](const char* what, const std::string& value) {
        out += core::text("%-12s ", what) + value + "\n";
    };
    line("format", "QSplat 11, of the original program");
    for (const mesh::QsplatFragment& f : info.file.fragments)
        line("fragment",
             core::text("%llu leaves, %llu nodes, %llu bytes%s, centre %.9g %.9g %.9g, radius %.9g",
                        number(f.leaves), number(f.nodes), number(f.bytes), f.has_colour ? ", colour" : "",
                        double(f.root.centre.x), double(f.root.centre.y), double(f.root.centre.z),
                        double(f.root.radius)));
    for (const std::string& comment : info.file.comments)
        for (std::istringstream lines(comment); std::getline(lines, text);) line("comment", text);
    line("leaves", core::text("%llu", number(info.leaves)));
    line("nodes", core::text("%llu, fan-out %.2f", number(info.nodes), fan_out(info)));
    line("levels", core::text("%zu", info.levels.size() - 1));
    line("file", core::text("%llu bytes, %.3f a leaf, %llu of them pointers", number(info.file_bytes),
                            per_leaf(info), number(info.pointers * mesh::kQsplatPointer)));
    out += "level      nodes     leaves  radius mean   radius max\n";
    for (size_t l = 0; l < info.levels.size(); ++l) {
        const QsplatLevel& level = info.levels[l];
        out += core::text("%5zu %10llu %10llu %12.5g %12.5g\n", l, number(level.nodes), number(level.leaves),
                          level.radius_mean, level.radius_max);
    }
    return out;
}

nlohmann::ordered_json to_json(const QsplatInfo& info) {
    nlohmann::ordered_json json;
    json["file"] = info.name;
    json["format"] = "qsplat 11";
    json["leaves"] = info.leaves;
    json["nodes"] = info.nodes;
    json["fan_out_mean"] = fan_out(info);
    json["level_count"] = info.levels.size() - 1;
    json["has_colour"] = info.has_colour;
    json["file_bytes"] = info.file_bytes;
    json["bytes_per_leaf"] = per_leaf(info);
    json["pointer_bytes"] = info.pointers * mesh::kQsplatPointer;
    json["comments"] = info.file.comments;
    json["fragments"] = nlohmann::ordered_json::array();
    for (const mesh::QsplatFragment& f : info.file.fragments)
        json["fragments"].push_back({{"centre", {f.root.centre.x, f.root.centre.y, f.root.centre.z}},
                                     {"radius", f.root.radius},
                                     {"leaves", f.leaves},
                                     {"nodes", f.nodes},
                                     {"bytes", f.bytes},
                                     {"has_colour", f.has_colour}});
    json["levels"] = nlohmann::ordered_json::array();
    for (size_t l = 0; l < info.levels.size(); ++l) {
        const QsplatLevel& level = info.levels[l];
        json["levels"].push_back({{"level", l},
                                  {"nodes", level.nodes},
                                  {"leaves", level.leaves},
                                  {"radius_mean", level.radius_mean},
                                  {"radius_max", level.radius_max}});
    }
    return json;
}

uint64_t write_qsplat_cut(const core::InputFile& file, uint32_t level, core::OutputFile& out) {
    const size_t last = read_qsplat_info(file).levels.size() - 1;
    if (level < 1 || level > last)
        throw core::Error(
            core::text("%s: there is no level %u; they go from 1 to %zu", file.name().c_str(), level, last));
    const mesh::Mesh points = mesh::read_qsplat(source_of(file), {}, level).mesh;
    out.write(mesh::to_ply(points));
    return points.positions.size();
}

}  // namespace splat
