#include "splat/extract.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <unordered_map>

#include "core/bytes.h"
#include "core/error.h"
#include "splat/triangle_reader.h"
#include "splat/walk.h"

namespace splat {

namespace {

constexpr size_t kBufferSize = size_t(1) << 20;

bool needs_double(const Header& h) {
    constexpr double kHalfStep = 0x1p-25, kFinest = 1e-6;  // of a coordinate; of the model's radius
    const double farthest =
        std::max({std::fabs(h.origin.x), std::fabs(h.origin.y), std::fabs(h.origin.z)}) + h.scale;
    return farthest * kHalfStep > kFinest * h.scale;
}

glm::u8vec3 colour_of(const Header& h, uint16_t code) {
    return h.flags & kConstantColour ? glm::u8vec3(h.colour[0], h.colour[1], h.colour[2])
                                     : decode_colour(code);
}

class CutWriter {
  public:
    CutWriter(const Header& header, core::OutputFile& out)
        : header_(header),
          out_(out),
          has_colour_(header.flags & (kHasColour | kConstantColour)),
          is_double_(needs_double(header)) {}

    void write_header(uint64_t count, uint32_t level) {
        const std::string coordinate = is_double_ ? "double" : "float";
        std::string text = core::text(
            "ply\nformat binary_little_endian 1.0\ncomment cut at level %u of %u\nelement vertex %llu\n",
            level, header_.level_count, static_cast<unsigned long long>(count));
        for (const char* name : {"x", "y", "z"}) text += "property " + coordinate + " " + name + "\n";
        for (const char* name : {"nx", "ny", "nz", "radius", "flatness", "error"})
            text += std::string("property float ") + name + "\n";
        if (has_colour_)
            for (const char* name : {"red", "green", "blue"})
                text += std::string("property uchar ") + name + "\n";
        out_.write(text + "end_header\n");
    }

    void add(const Node& node) {
        const glm::dvec3 at = header_.origin + header_.scale * node.centre;
        for (int k = 0; k < 3; ++k) is_double_ ? bytes_.put(at[k]) : bytes_.put(float(at[k]));
        for (int k = 0; k < 3; ++k) bytes_.put(node.normal[k]);
        bytes_.put(float(double(node.radius) * header_.scale));
        bytes_.put(node.flatness);
        bytes_.put(float(double(node.error) * header_.scale));
        if (has_colour_) put_colour(node);
        if (bytes_.bytes.size() >= kBufferSize) flush();
    }

    void flush() {
        out_.write(bytes_.bytes);
        bytes_.bytes.clear();
    }

  private:
    void put_colour(const Node& node) {
        const glm::u8vec3 colour = colour_of(header_, node.colour);
        for (int k = 0; k < 3; ++k) bytes_.put(colour[k]);
    }

    const Header& header_;
    core::OutputFile& out_;
    const bool has_colour_, is_double_;
    core::ByteWriter bytes_;
};

class MeshWriter {
  public:
    MeshWriter(const Model& model, core::OutputFile& out)
        : model_(model),
          header_(model.header()),
          out_(out),
          has_colour_(header_.flags & (kHasColour | kConstantColour)),
          is_double_(needs_double(header_)) {}

    uint64_t write() {
        for_triangles([&](const glm::u32vec3&, uint16_t) { ++triangles_; });
        write_header();
        for (const glm::i64vec3& p : vertices_) {
            const glm::dvec3 at =
                header_.origin +
                header_.scale * (glm::dvec3(p) * std::ldexp(1.0, -int(header_.lattice_bits)));
            for (int k = 0; k < 3; ++k) is_double_ ? bytes_.put(at[k]) : bytes_.put(float(at[k]));
            flush_at(kBufferSize);
        }
        for_triangles([&](const glm::u32vec3& corners, uint16_t colour) {
            bytes_.put(uint8_t(3));
            for (int k = 0; k < 3; ++k) bytes_.put(corners[k]);
            const glm::u8vec3 rgb = colour_of(header_, colour);
            for (int k = 0; has_colour_ && k < 3; ++k) bytes_.put(rgb[k]);
            flush_at(kBufferSize);
        });
        flush_at(0);
        return triangles_;
    }

  private:
    // Calls use(vertices, colour code) for each triangle, in the order of the file.
    template <class Use>
    void for_triangles(const Use& use) {
        BlockView nodes;
        BlockTriangles triangles;
        for (uint64_t b = 0; b < model_.node_blocks_present(); ++b) {
            nodes.open(model_, b);
            triangles.open(model_, nodes);
            for (uint32_t slot = 0; slot < nodes.node_count(); ++slot) {
                if (nodes.children_of(slot) > 0) continue;
                const BlockTriangles::Place at = triangles.find(slot);
                if (at.run == BlockTriangles::Place::kNone)
                    throw core::Error(
                        core::text("%s: cut off at byte %zu, before the last triangles; level %u has points",
                                   model_.name().c_str(), model_.size_bytes(), header_.level_count - 1));
                const TriangleRun& run = triangles.runs()[at.run].run;
                const glm::u32vec3 entries = run.entries(at.triangle);
                glm::u32vec3 corners;
                for (int k = 0; k < 3; ++k) corners[k] = number_of(run.position(entries[k]));
                use(corners, nodes.colour() ? nodes.colour()[slot] : uint16_t(0));
            }
        }
    }

    uint32_t number_of(const glm::i64vec3& p) {
        const auto [at, is_new] = numbers_.try_emplace({p.x, p.y, p.z}, uint32_t(vertices_.size()));
        if (is_new) vertices_.push_back(p);
        return at->second;
    }

    void write_header() {
        std::string text = core::text(
            "ply\nformat binary_little_endian 1.0\ncomment triangles of a splat model\nelement vertex %zu\n",
            vertices_.size());
        for (const char* name : {"x", "y", "z"})
            text += core::text("property %s %s\n", is_double_ ? "double" : "float", name);
        text += core::text("element face %llu\nproperty list uchar uint vertex_indices\n",
                           static_cast<unsigned long long>(triangles_));
        if (has_colour_)
            for (const char* name : {"red", "green", "blue"})
                text += std::string("property uchar ") + name + "\n";
        out_.write(text + "end_header\n");
    }

    void flush_at(size_t size) {
        if (bytes_.bytes.size() < size) return;
        out_.write(bytes_.bytes);
        bytes_.bytes.clear();
    }

    struct Hash {
        size_t operator()(const std::array<int64_t, 3>& p) const {
            uint64_t h = 0;
            for (const int64_t v : p) h = (h ^ uint64_t(v)) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
            return h;
        }
    };

    const Model& model_;
    const Header& header_;
    core::OutputFile& out_;
    const bool has_colour_, is_double_;
    std::unordered_map<std::array<int64_t, 3>, uint32_t, Hash> numbers_;
    std::vector<glm::i64vec3> vertices_;
    uint64_t triangles_ = 0;
    core::ByteWriter bytes_;
};

}  // namespace

CutWritten write_cut(const Model& model, uint32_t level, core::OutputFile& out) {
    const Header& h = model.header();
    if (level > h.level_count)
        throw core::Error(core::text("%s: there is no level %u, the last is %u", model.name().c_str(), level,
                                     h.level_count));
    if (h.has_triangles() && level == h.level_count) return {0, MeshWriter(model, out).write()};
    uint64_t count = 0;
    walk_cut(model, level, [&](const Node&) { ++count; });
    CutWriter writer(h, out);
    writer.write_header(count, level);
    walk_cut(model, level, [&](const Node& node) { writer.add(node); });
    writer.flush();
    return {count, 0};
}

}  // namespace splat
