#include "splat/build/run_packer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

namespace splat {

// A row of bits that grows.
class RunPacker::Writer {
  public:
    explicit Writer(std::vector<std::byte>& out) : out_(out), begin_(out.size()) {}
    void put(uint64_t value, uint32_t width) {  // width <= 48
        held_ |= (value & ((uint64_t(1) << width) - 1)) << count_;
        for (count_ += width; count_ >= 8; count_ -= 8, held_ >>= 8) out_.push_back(std::byte(held_ & 255u));
    }
    // Fills up the last byte, and says how many there are.
    void finish() {
        if (count_ > 0) out_.push_back(std::byte(held_ & 255u));
        const size_t size = out_.size() - begin_;
        for (size_t k = 0; k < kRunSizeBytes; ++k) out_[begin_ + k] = std::byte(size >> (8 * k) & 255u);
    }

  private:
    std::vector<std::byte>& out_;
    const size_t begin_;
    uint64_t held_ = 0;
    uint32_t count_ = 0;
};

namespace {

// Bits that a number takes in two's complement, 0 for 0.
uint32_t signed_width(int64_t value) {
    return value == 0 ? 0 : uint32_t(std::bit_width(uint64_t(value < 0 ? ~value : value))) + 1;
}
template <class Vector>
uint32_t widest(const Vector& v) {
    uint32_t width = 0;
    for (int k = 0; k < int(v.length()); ++k) width = std::max(width, signed_width(v[k]));
    return width;
}

// How many corners take how many bits a coordinate.
using Widths = std::array<uint32_t, 40>;

// The narrowest class that is wide enough; width_of(class) does not fall.
template <class WidthOf>
uint32_t class_of(uint32_t width, const WidthOf& width_of) {
    uint32_t size_class = 0;
    while (width_of(size_class) < width) ++size_class;
    return size_class;
}

// The width below `end` with which the fewest bits are taken.
template <class WidthOf>
uint32_t choose_width(const Widths& widths, uint32_t end, const WidthOf& width_of) {
    uint32_t best = 0;
    uint64_t fewest = ~uint64_t(0);
    for (uint32_t width = 0; width < end; ++width) {
        uint64_t bits = 0;
        for (uint32_t w = 0; w < widths.size(); ++w)
            if (widths[w] > 0) {
                const auto of = [&](uint32_t c) { return width_of(width, c); };
                bits += uint64_t(widths[w]) * of(class_of(w, of));
            }
        if (bits < fewest) fewest = bits, best = width;
    }
    return best;
}

}  // namespace

// The latest edge; `first`: the corner that it begins with.
RunPacker::Glue RunPacker::find_glue(const Corner (&corners)[3], int& first) {
    uint32_t entry[3];
    for (int k = 0; k < 3; ++k) entry[k] = entry_of_.find(corners[k].vertex).number;
    Glue latest;
    for (int k = 0; k < 3; ++k) {
        const uint32_t from = entry[(k + 1) % 3], to = entry[k];
        if (from == Entry::kNone || to == Entry::kNone) continue;
        const Glue found = glue_of_.find(uint64_t(from) << 32 | to);
        if (found.triangle == Glue::kNone ||
            (latest.triangle != Glue::kNone && found.triangle <= latest.triangle))
            continue;
        latest = found, first = k;
    }
    return latest;
}

uint32_t RunPacker::take_entry(const Corner& corner, const Parallelogram& expected) {
    Entry& entry = entry_of_[corner.vertex];
    if (entry.number == Entry::kNone) {
        entry.number = uint32_t(normals_.size());
        for (int axis = 0; axis < 3; ++axis) positions_[axis].push_back(corner.position[axis]);
        normals_.push_back(corner.normal), needs_normal_.push_back(false);
        expected_.push_back(expected);
    }
    return entry.number;
}

void RunPacker::add(const Corner (&corners)[3], bool is_smooth) {
    assert(!is_full());
    int first = 0;
    const Glue glue = find_glue(corners, first);
    glm::u32vec3 triangle;
    for (int k = 0; k < 3; ++k) {
        const auto before = uint32_t(std::max<size_t>(normals_.size(), 1) - 1);
        Parallelogram expected{before, before, before};
        if (k == 2 && glue.triangle != Glue::kNone)
            expected = {triangle.x, triangle.y, triangles_[glue.triangle][(glue.edge + 2) % 3]};
        triangle[k] = take_entry(corners[(first + k) % 3], expected);
    }
    for (int k = 0; k < 3; ++k) {
        glue_of_[uint64_t(triangle[k]) << 32 | triangle[(k + 1) % 3]] = {uint32_t(triangles_.size()),
                                                                         uint32_t(k)};
        needs_normal_[triangle[k]] |= uint8_t(is_smooth);
    }
    triangles_.push_back(triangle), glue_.push_back(glue), smooth_.push_back(is_smooth);
}

void RunPacker::write_triangles(Writer& bits) const {
    uint32_t next = 0;
    const auto put_corner = [&](uint32_t entry) {
        bits.put(entry == next, 1);
        if (entry == next)
            ++next;
        else
            bits.put(entry, uint32_t(std::bit_width(next - 1)));
    };
    for (uint32_t t = 0; t < triangles_.size(); ++t) {
        const Glue& glue = glue_[t];
        bits.put(glue.triangle != Glue::kNone, 1);
        if (glue.triangle == Glue::kNone) {
            for (int k = 0; k < 3; ++k) put_corner(triangles_[t][k]);
            continue;
        }
        const uint32_t back = t - glue.triangle, zeros = uint32_t(std::bit_width(back)) - 1;
        bits.put(1u << zeros, zeros + 1), bits.put(back, zeros);
        bits.put(glue.edge == 0 ? 0 : glue.edge == 1 ? 1 : 3, glue.edge == 0 ? 1 : 2);
        put_corner(triangles_[t].z);
    }
}

glm::i64vec3 RunPacker::off_expected(size_t entry) const {
    const Parallelogram& from = expected_[entry];
    glm::i64vec3 off;
    for (int axis = 0; axis < 3; ++axis) {
        const std::vector<int32_t>& p = positions_[axis];
        off[axis] = p[entry] - (entry == 0 ? 0 : int64_t(p[from.a]) + p[from.b] - p[from.c]);
    }
    return off;
}

// 0 where no smooth triangle asks for it.
glm::ivec2 RunPacker::off_told(size_t entry) const {
    if (!needs_normal_[entry]) return glm::ivec2(0);
    const auto steps = [](uint32_t code) { return glm::ivec2(code & 4095u, code >> 12); };
    return steps(normals_[entry]) - steps(told_normals_[entry]);
}

void RunPacker::finish(std::vector<std::byte>& out) {
    const auto smooth = size_t(std::count(smooth_.begin(), smooth_.end(), 1));
    const RunShading shading = smooth == 0                ? RunShading::flat
                               : smooth == smooth_.size() ? RunShading::smooth
                                                          : RunShading::mixed;
    told_normals_.resize(normals_.size());
    tell_corner_normals(triangles_, positions_, told_normals_);
    Widths position_widths{}, normal_widths{};
    for (size_t e = 0; e < normals_.size(); ++e)
        ++position_widths[widest(off_expected(e))], ++normal_widths[widest(off_told(e))];
    const auto position_width_of = [&](uint32_t width, uint32_t c) {
        return position_width(width, c, lattice_bits_);
    };
    const uint32_t position_bits = choose_width(
        position_widths, std::min(lattice_bits_, (1u << kPositionWidthBits) - 1), position_width_of);
    const uint32_t normal_bits = choose_width(normal_widths, kCornerNormalBits - kClassStep, normal_width);

    Writer bits(out);
    bits.put(0, kRunSizeBits);
    bits.put(triangles_.size() - 1, kRunTriangleBits), bits.put(normals_.size() - 1, kRunCornerBits);
    bits.put(uint32_t(shading), kRunShadingBits);
    bits.put(position_bits, kPositionWidthBits), bits.put(normal_bits, kNormalWidthBits);
    write_triangles(bits);
    // Each coordinate as wide as the widest needs it.
    const auto put = [&](const auto& off, const auto& width_of) {
        const uint32_t size_class = class_of(widest(off), width_of);
        bits.put(size_class, kClassBits);
        for (int k = 0; k < int(off.length()); ++k) bits.put(uint64_t(int64_t(off[k])), width_of(size_class));
    };
    for (size_t e = 0; e < normals_.size(); ++e)
        put(off_expected(e), [&](uint32_t c) { return position_width_of(position_bits, c); });
    for (size_t e = 0; shading != RunShading::flat && e < normals_.size(); ++e)
        put(off_told(e), [&](uint32_t c) { return normal_width(normal_bits, c); });
    for (size_t t = 0; shading == RunShading::mixed && t < smooth_.size(); ++t) bits.put(smooth_[t], 1);
    bits.finish();

    entry_of_.clear(), glue_of_.clear();
    for (auto& axis : positions_) axis.clear();
    normals_.clear(), needs_normal_.clear(), expected_.clear();
    triangles_.clear(), glue_.clear(), smooth_.clear();
}

}  // namespace splat
