#include "splat/triangle_run.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "core/error.h"
#include "splat/coding/glue_code.h"

namespace splat {

// The bits of a run, of which a few at a time are looked at, however many there are: at_end() tells.
class TriangleRun::Bits {
  public:
    explicit Bits(std::span<const std::byte> bytes) : bytes_(bytes.data()), size_(8 * bytes.size()) {}

    // The next 57 bits at least.
    uint64_t peek() const {
        uint64_t word;
        std::memcpy(&word, bytes_ + at_ / 8, sizeof(word));
        return word >> at_ % 8;
    }
    void skip(uint32_t count) { at_ += count; }
    uint32_t take(uint32_t count) {  // count <= 32
        const uint64_t word = peek() & ((uint64_t(1) << count) - 1);
        at_ += count;
        return uint32_t(word);
    }
    // Two's complement.
    int64_t take_signed(uint32_t count) {  // count <= 48
        const uint64_t word = peek() & ((uint64_t(1) << count) - 1), sign = (uint64_t(1) << count) >> 1;
        at_ += count;
        return int64_t(word ^ sign) - int64_t(sign);
    }
    bool is_past_end() const { return at_ > size_; }
    // At the last byte's end, but for zeros.
    bool is_at_end() const {
        return at_ <= size_ && size_ - at_ < 8 && (peek() & ((1u << (size_ - at_)) - 1)) == 0;
    }

  private:
    const std::byte* bytes_;
    size_t at_ = 0;  // bits
    size_t size_;
};

namespace {

// What one triangle, or corner, takes is looked at before it is known to be there.
static_assert(kRunReadAhead >= 8 + (2 + 3 * any_position_width(30)) / 8);
// Of most: by their first bits; those that are longer have 0 bits here.
struct GlueCodes {
    static constexpr uint32_t kBits = 9;
    std::array<GlueCode, 1 << kBits> of;
};
constexpr GlueCodes kGlueCodes = [] {
    GlueCodes codes{};
    for (uint32_t word = 0; word < codes.of.size(); ++word) {
        const GlueCode code = long_glue_code(word);
        if (code.back < kMostRunTriangles && code.bits <= GlueCodes::kBits) codes.of[word] = code;
    }
    return codes;
}();

constexpr int kAfter[3] = {1, 2, 0};

uint32_t index_width(uint32_t count) {
    return uint32_t(std::bit_width(count - 1));
}

}  // namespace

std::string TriangleRun::read(std::span<const std::byte> bytes, uint32_t lattice_bits) {
    Bits bits(bytes);
    size_ = bits.take(kRunSizeBits);
    entries_.resize(bits.take(kRunTriangleBits) + 1);
    corners_ = bits.take(kRunCornerBits) + 1;
    shading_ = RunShading(bits.take(kRunShadingBits));
    position_width_ = bits.take(kPositionWidthBits), normal_width_ = bits.take(kNormalWidthBits);
    if (size_ != bytes.size() || bits.is_past_end()) return core::text("a run of %zu bytes", size_);
    if (shading_ > RunShading::mixed) return "triangles that are neither smooth nor flat";
    std::string fault = read_triangles(bits);
    if (fault.empty()) fault = read_positions(bits, lattice_bits);
    if (fault.empty() && has_normals()) fault = read_normals(bits);
    if (fault.empty() && shading_ == RunShading::mixed) {
        smooth_.resize(triangles());
        for (size_t t = 0; t < smooth_.size() && !bits.is_past_end(); ++t) smooth_[t] = uint8_t(bits.take(1));
    }
    if (fault.empty() && !bits.is_at_end())
        fault = core::text("a run does not end with its %zu bytes", size_);
    return fault;
}

std::string TriangleRun::read_triangles(Bits& run_bits) {
    Bits bits = run_bits;
    expected_.resize(corners_ + 1);  // one may be noted beyond the last
    uint32_t next = 0;               // entry that no triangle had yet
    bool is_whole = true;
    // Takes the corner behind `before` bits of `word`.  Without branches: whether it is new is anyone's
    // guess.
    const auto take_corner = [&](uint64_t word, uint32_t before, const Parallelogram& expected) -> uint32_t {
        const uint32_t is_next = uint32_t(word >> before) & 1, had_width = index_width(std::max(next, 1u));
        const uint32_t width = had_width & (is_next - 1);
        const uint32_t had = uint32_t(word >> (before + 1)) & ((1u << had_width) - 1);
        bits.skip(before + 1 + width);
        const uint32_t entry = had ^ ((had ^ next) & (0u - is_next));
        expected_[std::min(next, corners_)] = expected;
        next += is_next;
        is_whole &= (entry < next) & (next <= corners_);
        return entry;
    };
    for (uint32_t t = 0; t < triangles(); ++t) {
        const uint64_t word = bits.peek();
        glm::u32vec3& triangle = entries_[t];
        if (!(word & 1)) {
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t before = std::max(next, 1u) - 1;
                triangle[int(k)] = take_corner(k == 0 ? word : bits.peek(), k == 0, {before, before, before});
            }
        } else {
            GlueCode code = kGlueCodes.of[word >> 1 & (kGlueCodes.of.size() - 1)];
            if (code.bits == 0) code = long_glue_code(word >> 1);
            if (code.back > t) return core::text("triangle %u is glued to none before it", t);
            const glm::u32vec3 to = entries_[t - code.back];
            const Parallelogram expected{to[kAfter[code.edge]], to[code.edge], to[kAfter[kAfter[code.edge]]]};
            triangle = {expected.a, expected.b, take_corner(word, 1u + code.bits, expected)};
        }
        if (!is_whole || bits.is_past_end())
            return core::text("triangle %u has an entry beyond its table", t);
    }
    if (next != corners_) return core::text("%u corners, its triangles have %u", corners_, next);
    run_bits = bits;
    return {};
}

std::string TriangleRun::read_positions(Bits& run_bits, uint32_t lattice_bits) {
    Bits bits = run_bits;
    for (auto& axis : positions_) axis.resize(corners_ + kRoom);
    uint32_t widths[4];
    for (uint32_t c = 0; c < 4; ++c) widths[c] = position_width(position_width_, c, lattice_bits);
    const int64_t limit = int64_t(1) << lattice_bits;
    for (uint32_t e = 0; e < corners_; ++e) {
        const uint32_t width = widths[bits.take(kClassBits)];
        const Parallelogram& from = expected_[e];
        bool is_inside = true;
        for (auto& axis : positions_) {
            const int64_t told = e == 0 ? 0 : int64_t(axis[from.a]) + axis[from.b] - axis[from.c];
            const int64_t value = told + bits.take_signed(width);
            is_inside &= -limit <= value && value <= limit;
            axis[e] = int32_t(value);
        }
        if (!is_inside || bits.is_past_end()) return core::text("corner %u is outside the lattice", e);
    }
    run_bits = bits;
    return {};
}

std::string TriangleRun::read_normals(Bits& run_bits) {
    Bits bits = run_bits;
    normals_.resize(corners_ + kRoom);
    tell_corner_normals(entries_, positions_, std::span(normals_).first(corners_));
    uint32_t widths[4];
    for (uint32_t c = 0; c < 4; ++c) widths[c] = normal_width(normal_width_, c);
    for (uint32_t e = 0; e < corners_; ++e) {
        const uint32_t size_class = bits.take(kClassBits);
        if (size_class == 0) continue;
        const uint32_t width = widths[size_class], told = normals_[e];
        const int64_t column = int64_t(told & 4095u) + bits.take_signed(width),
                      row = int64_t(told >> 12) + bits.take_signed(width);
        if (std::min(column, row) < 0 || std::max(column, row) >= kCornerNormalSteps || bits.is_past_end())
            return core::text("normal of corner %u has column %lld and row %lld", e,
                              static_cast<long long>(column), static_cast<long long>(row));
        normals_[e] = uint32_t(column | row << 12);
    }
    run_bits = bits;
    return {};
}

}  // namespace splat
