#include "splat/extract.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/bytes.h"
#include "core/error.h"
#include "splat/walk.h"

namespace splat {

namespace {

constexpr size_t kBufferSize = size_t(1) << 20;

// Calls use(node) for each node of the cut.
template <class Use>
void for_cut(const Model& model, uint32_t level, const Use& use) {
    if (level == 0) return use(model.root());
    walk(model, level, [&](const WalkedNode& n) {
        if (n.level == level || n.node.children == 0 || n.lacks_children) use(n.node);
    });
}

bool needs_double(const Header& h) {
    constexpr double kHalfStep = 0x1p-25, kFinest = 1e-6;  // of a coordinate; of the model's radius
    const double farthest =
        std::max({std::fabs(h.origin.x), std::fabs(h.origin.y), std::fabs(h.origin.z)}) + h.scale;
    return farthest * kHalfStep > kFinest * h.scale;
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
        const bool is_constant = header_.flags & kConstantColour;
        const glm::u8vec3 colour = is_constant
                                       ? glm::u8vec3(header_.colour[0], header_.colour[1], header_.colour[2])
                                       : decode_colour(node.colour);
        for (int k = 0; k < 3; ++k) bytes_.put(colour[k]);
    }

    const Header& header_;
    core::OutputFile& out_;
    const bool has_colour_, is_double_;
    core::ByteWriter bytes_;
};

}  // namespace

uint64_t write_cut(const Model& model, uint32_t level, core::OutputFile& out) {
    const Header& h = model.header();
    if (level > h.level_count)
        throw core::Error(core::text("%s: there is no level %u, the last is %u", model.name().c_str(), level,
                                     h.level_count));
    uint64_t count = 0;
    for_cut(model, level, [&](const Node&) { ++count; });
    CutWriter writer(h, out);
    writer.write_header(count, level);
    for_cut(model, level, [&](const Node& node) { writer.add(node); });
    writer.flush();
    return count;
}

}  // namespace splat
