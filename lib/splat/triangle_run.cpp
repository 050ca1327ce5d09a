#include "splat/triangle_run.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"

namespace splat {

namespace {

constexpr uint32_t kCountBits = 7, kCornerCountBits = 9, kWidthBits = 5, kHeadBits = 32;
constexpr uint32_t kNormalWidthBits = 4, kNormalHeadBits = 2 * (kNormalWidthBits + kCornerNormalBits);

uint32_t width_of(uint32_t most) {
    return uint32_t(std::bit_width(most));
}
uint32_t width_between(int low, int high) {
    return width_of(uint32_t(high) - uint32_t(low));
}
glm::uvec2 steps_of(uint32_t normal) {
    return {normal & 4095u, normal >> 12};
}

// A row of bits that grows.
class BitWriter {
  public:
    explicit BitWriter(std::vector<std::byte>& out) : out_(out) {}
    void put(uint64_t value, uint32_t width) {  // width <= 32
        held_ |= value << count_;
        for (count_ += width; count_ >= 8; count_ -= 8, held_ >>= 8) out_.push_back(std::byte(held_ & 255u));
    }
    void finish() {
        if (count_ > 0) out_.push_back(std::byte(held_ & 255u));
        count_ = 0, held_ = 0;
    }

  private:
    std::vector<std::byte>& out_;
    uint64_t held_ = 0;
    uint32_t count_ = 0;
};

}  // namespace

uint32_t encode_corner_normal(const glm::dvec3& n) {
    constexpr double kMiddle = (kCornerNormalSteps - 1) / 2;
    const double sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
    if (!(sum > 0)) return 0;
    double x = n.x / sum, y = n.y / sum;
    if (n.z < 0) {
        const double folded = std::copysign(1 - std::fabs(y), x);
        y = std::copysign(1 - std::fabs(x), y), x = folded;
    }
    const auto step = [&](double v) { return uint32_t(std::lround(v * kMiddle) + long(kMiddle)); };
    return step(x) | step(y) << 12;
}

glm::vec3 decode_corner_normal(uint32_t code) {
    constexpr float kMiddle = (kCornerNormalSteps - 1) / 2;
    const float x = (float(code & 4095u) - kMiddle) / kMiddle,
                y = (float(code >> 12 & 4095u) - kMiddle) / kMiddle;
    const float ax = std::fabs(x), ay = std::fabs(y);
    glm::vec3 n(x, y, 1.0f - ax - ay);
    if (n.z < 0.0f) n.x = std::copysign(1.0f - ay, x), n.y = std::copysign(1.0f - ax, y);
    const float s = 1.0f / std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return {n.x * s, n.y * s, n.z * s};
}

uint32_t TriangleRun::bits(size_t at, uint32_t count) const {
    const size_t byte = at / 8;
    uint64_t word = 0;
    std::memcpy(&word, bytes_.data() + byte, std::min(sizeof(word), bytes_.size() - byte));
    return uint32_t(word >> at % 8 & ((uint64_t(1) << count) - 1));
}

std::string TriangleRun::open(std::span<const std::byte> used, size_t offset, uint32_t lattice_bits) {
    const size_t base_bits = 3 * size_t(lattice_bits + 1);
    if (offset > used.size() || (used.size() - offset) * 8 < kHeadBits + base_bits)
        return core::text("a run at byte %zu goes beyond its block's %zu", offset, used.size());
    bytes_ = used.subspan(offset);
    size_t at = 0;
    const auto take = [&](uint32_t width) {
        at += width;
        return bits(at - width, width);
    };
    triangles_ = take(kCountBits) + 1, corners_ = take(kCornerCountBits) + 1;
    position_width_ = 0;
    for (uint32_t& width : width_) position_width_ += width = take(kWidthBits);
    has_normals_ = take(1);
    for (int axis = 0; axis < 3; ++axis)
        base_[axis] = int64_t(take(lattice_bits + 1)) - (int64_t(1) << lattice_bits);
    if (has_normals_) {
        if (bytes_.size() * 8 < at + kNormalHeadBits)
            return core::text("a run at byte %zu goes beyond its block's %zu", offset, used.size());
        for (uint32_t& width : normal_width_) width = take(kNormalWidthBits);
        for (uint32_t& base : normal_base_) base = take(kCornerNormalBits);
    }
    positions_at_ = at;
    normals_at_ = positions_at_ + size_t(corners_) * position_width_;
    entries_at_ = normals_at_ + (has_normals_ ? size_t(corners_) * (normal_width_[0] + normal_width_[1]) : 0);
    // Each entry of the table is once the next one.
    const size_t used_before = std::max<size_t>(3 * size_t(triangles_), corners_) - corners_;
    end_ = entries_at_ + 3 * size_t(triangles_) + used_before * width_of(corners_ - 1) +
           (has_normals_ ? triangles_ : 0);
    if (size_bytes() > bytes_.size())
        return core::text("a run of %zu bytes at byte %zu goes beyond its block's %zu", size_bytes(), offset,
                          used.size());
    bytes_ = bytes_.first(size_bytes());
    return {};
}

bool TriangleRun::has_zero_padding() const {
    return end_ % 8 == 0 || bits(end_, uint32_t(8 - end_ % 8)) == 0;
}

glm::i64vec3 TriangleRun::position(uint32_t entry) const {
    size_t at = positions_at_ + size_t(entry) * position_width_;
    glm::i64vec3 p = base_;
    for (int axis = 0; axis < 3; ++axis) p[axis] += bits(at, width_[axis]), at += width_[axis];
    return p;
}

uint32_t TriangleRun::normal_code(uint32_t entry) const {
    if (!has_normals_) return 0;
    const size_t at = normals_at_ + size_t(entry) * (normal_width_[0] + normal_width_[1]);
    const uint32_t column = normal_base_[0] + bits(at, normal_width_[0]),
                   row = normal_base_[1] + bits(at + normal_width_[0], normal_width_[1]);
    return column | row << 12;
}

std::string TriangleRun::read_entries(std::vector<glm::u32vec3>& entries) const {
    const uint32_t width = width_of(corners_ - 1);
    size_t at = entries_at_;
    uint32_t next = 0;
    const size_t end = end_ - (has_normals_ ? triangles_ : 0);
    entries.resize(triangles_);
    for (uint32_t t = 0; t < triangles_; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t word = bits(at, 1 + width);
            const bool is_next = word & 1;
            entries[t][k] = is_next ? next++ : word >> 1;
            at += is_next ? 1 : 1 + width;
            if (next > corners_ || entries[t][k] >= next || at > end)
                return core::text("triangle %u has an entry beyond its table", t);
        }
    return at == end && next == corners_ ? std::string()
                                         : core::text("%u corners, its triangles have %u", corners_, next);
}

size_t RunPacker::size_bits(const Extent& e) const {
    size_t entry = 0, head = kHeadBits + 3 * size_t(lattice_bits_ + 1);
    for (int axis = 0; axis < 3; ++axis) entry += width_between(e.low[axis], e.high[axis]);
    if (e.has_normals) {
        const glm::uvec2 wide = e.normal_high - e.normal_low;
        entry += width_of(wide.x) + width_of(wide.y);
        head += kNormalHeadBits + e.triangles;
    }
    return head + e.corners * entry + 3 * e.triangles +
           (3 * e.triangles - e.corners) * width_of(uint32_t(e.corners - 1));
}

bool RunPacker::add(const Corner (&corners)[3], bool is_smooth, size_t room) {
    if (is_full()) return false;
    const size_t known = table_.size();
    Extent grown = extent_;
    if (known == 0) grown.low = grown.high = corners[0].position;
    ++grown.triangles;
    grown.has_normals |= is_smooth;
    glm::u32vec3 entry;
    for (int k = 0; k < 3; ++k) {
        const auto is_same = [&](const Corner& c) { return c.vertex == corners[k].vertex; };
        const auto at = std::find_if(table_.begin(), table_.end(), is_same);
        entry[k] = uint32_t(at - table_.begin());
        if (at == table_.end()) table_.push_back(corners[k]);
        grown.low = glm::min(grown.low, corners[k].position),
        grown.high = glm::max(grown.high, corners[k].position);
        if (!is_smooth) continue;
        const glm::uvec2 steps = steps_of(corners[k].normal);
        grown.normal_low = glm::min(grown.normal_low, steps),
        grown.normal_high = glm::max(grown.normal_high, steps);
    }
    grown.corners = table_.size();
    if (size_bits(grown) > 8 * room) {
        table_.resize(known);
        return false;
    }
    extent_ = grown;
    needs_normal_.resize(table_.size(), false);
    for (int k = 0; k < 3; ++k) needs_normal_[entry[k]] |= uint8_t(is_smooth);
    triangles_.push_back(entry), smooth_.push_back(is_smooth);
    return true;
}

void RunPacker::finish(std::vector<std::byte>& out) {
    BitWriter bits(out);
    const Extent& e = extent_;
    bits.put(e.triangles - 1, kCountBits), bits.put(e.corners - 1, kCornerCountBits);
    uint32_t width[3];
    for (int axis = 0; axis < 3; ++axis)
        bits.put(width[axis] = width_between(e.low[axis], e.high[axis]), kWidthBits);
    bits.put(e.has_normals, 1);
    for (int axis = 0; axis < 3; ++axis)
        bits.put(uint64_t(int64_t(e.low[axis]) + (int64_t(1) << lattice_bits_)), lattice_bits_ + 1);
    const glm::uvec2 wide = e.normal_high - e.normal_low;
    if (e.has_normals) {
        for (int k = 0; k < 2; ++k) bits.put(width_of(wide[k]), kNormalWidthBits);
        for (int k = 0; k < 2; ++k) bits.put(e.normal_low[k], kCornerNormalBits);
    }
    for (const Corner& c : table_)
        for (int axis = 0; axis < 3; ++axis)
            bits.put(uint32_t(c.position[axis]) - uint32_t(e.low[axis]), width[axis]);
    for (size_t i = 0; e.has_normals && i < table_.size(); ++i) {
        // Those of flat triangles are not looked at.
        const glm::uvec2 above = needs_normal_[i] ? steps_of(table_[i].normal) - e.normal_low : glm::uvec2(0);
        for (int k = 0; k < 2; ++k) bits.put(above[k], width_of(wide[k]));
    }
    const uint32_t entry_width = width_of(uint32_t(e.corners - 1));
    uint32_t next = 0;
    for (const glm::u32vec3& t : triangles_)
        for (int k = 0; k < 3; ++k) {
            const bool is_next = t[k] == next;
            bits.put(is_next, 1);
            if (is_next)
                ++next;
            else
                bits.put(t[k], entry_width);
        }
    for (size_t t = 0; e.has_normals && t < triangles_.size(); ++t) bits.put(smooth_[t], 1);
    bits.finish();
    table_.clear(), needs_normal_.clear(), triangles_.clear(), smooth_.clear();
    extent_ = {};
}

}  // namespace splat
