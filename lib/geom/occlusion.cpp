#include "geom/occlusion.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <vector>

namespace geom {
namespace {

// Spheres that look smaller are not looked at: to leave them out would save no more than that costs.
constexpr float kLeastDiameterPx = 6;
// What is nearer than this many of its radii is never hidden: its splats may reach to the eye's plane.
constexpr float kClearRadii = 4;

// Blocks of the picture, inclusive.
struct Blocks {
    int x0, y0, x1, y1;
    bool is_empty() const { return x1 < x0 || y1 < y0; }
};

// Inverse depths by block, or by square of blocks; 0: nothing there.
struct Level {
    int across = 0, down = 0;
    std::vector<float> w;

    void resize(int a, int d) {
        across = a, down = d;
        w.resize(size_t(a) * size_t(d));
    }
    float* row(int y) { return w.data() + size_t(y) * size_t(across); }
    const float* row(int y) const { return w.data() + size_t(y) * size_t(across); }
};

// The least of each block and the eight around it.
void erode(const Level& from, Level& to) {
    to.resize(from.across, from.down);
    const int across = from.across;
    std::vector<float> least(size_t(across) + 2);  // of three rows, with a border
    for (int y = 0; y < from.down; ++y) {
        const float* above = from.row(std::max(y - 1, 0));
        const float* here = from.row(y);
        const float* below = from.row(std::min(y + 1, from.down - 1));
        for (int x = 0; x < across; ++x)
            least[size_t(x) + 1] = std::min(std::min(above[x], below[x]), here[x]);
        least.front() = least[1], least.back() = least[size_t(across)];
        float* out = to.row(y);
        for (int x = 0; x < across; ++x)
            out[x] = std::min(std::min(least[size_t(x)], least[size_t(x) + 2]), least[size_t(x) + 1]);
    }
}

// The least of each four.
void halve(const Level& from, Level& to) {
    to.resize((from.across + 1) / 2, (from.down + 1) / 2);
    for (int y = 0; y < to.down; ++y) {
        const float* above = from.row(2 * y);
        const float* below = from.row(std::min(2 * y + 1, from.down - 1));
        for (int x = 0; x < to.across; ++x) {
            const int left = 2 * x, right = std::min(2 * x + 1, from.across - 1);
            to.row(y)[x] = std::min(std::min(above[left], above[right]), std::min(below[left], below[right]));
        }
    }
}

}  // namespace

struct OcclusionMap::State {
    int left = 0, top = 0, right = 0, bottom = 0;  // pixels of the raster, without the last two
    int first_x = 0, first_y = 0;                  // its first block, of the picture's
    int across = 0, down = 0;                      // blocks
    float focal = 1, centre_x = 0, centre_y = 0, near = 0;
    // By thread: the nearest surface in the middle of each block.
    tbb::enumerable_thread_specific<std::vector<float>> surfaces;
    Level nearest;
    // What surely covers each square of 1, 2, 4 or 8 blocks, as far as surfaces tell: nodes that are looked
    // at span few of the largest.
    std::array<Level, 4> covers;
    std::vector<uint32_t> limits;  // bits of floats, which order as the floats: none is negative
    std::vector<uint8_t> unproven;
    std::atomic<bool> has_hidden{false}, has_unproven{false};
    bool is_repeated = false;

    size_t index(int bx, int by) const { return size_t(by) * size_t(across) + size_t(bx); }
    size_t index_of_pixel(int x, int y) const { return index(x / kBlock - first_x, y / kBlock - first_y); }
    float middle_x(int bx) const { return float((first_x + bx) * kBlock + kBlock / 2); }
    float middle_y(int by) const { return float((first_y + by) * kBlock + kBlock / 2); }

    // Blocks where a sphere, or a square or disc inside of it that faces the screen, may cover a pixel.  With
    // r = radius / z the outline is about (x / z) / (1 - r^2), and at most r sqrt(1 + (x / z)^2) / (1 - r^2)
    // wide to either side.
    Blocks blocks_of(const glm::vec3& p, float radius) const {
        const float inverse_z = 1 / p.z, r = radius * inverse_z, tx = p.x * inverse_z, ty = p.y * inverse_z;
        const float scale = focal / (1 - r * r);
        // More than float, and what splats reach beyond their outlines, can be off by.
        const float off_by = 0.02f + 1e-6f * float(right + bottom);
        const float half_x = r * std::sqrt(1 + tx * tx) * scale + off_by;
        const float half_y = r * std::sqrt(1 + ty * ty) * scale + off_by;
        const float x = centre_x + tx * scale, y = centre_y + ty * scale;
        // Written so that what is no number becomes one.
        const auto block = [](float pixel, int begin, int end) {
            return int(std::floor(std::min(std::max(float(begin - 1), pixel), float(end)) * (1.0f / kBlock)));
        };
        return {std::max(block(x - half_x, left, right) - first_x, 0),
                std::max(block(y - half_y, top, bottom) - first_y, 0),
                std::min(block(x + half_x, left, right) - first_x, across - 1),
                std::min(block(y + half_y, top, bottom) - first_y, down - 1)};
    }

    void add(const Surface& s, std::vector<float>& to) const {
        const float towards = glm::dot(s.normal, s.centre);
        if (!(s.centre.z > kClearRadii * s.radius && s.centre.z - s.radius > near && towards != 0)) return;
        const Blocks blocks = blocks_of(s.centre, s.radius);
        const float inverse_focal = 1 / focal, inverse_towards = 1 / towards;
        // Splats in front must stand clear by about their radii, which this is more than.
        const float behind = s.thickness + s.radius;
        const glm::vec3 p = s.centre, n = s.normal * inverse_towards;
        const float radius2 = s.radius * s.radius;
        for (int by = blocks.y0; by <= blocks.y1; ++by) {
            const float dy = (middle_y(by) - centre_y) * inverse_focal;
            const float row_w = n.y * dy + n.z;
            float* row = &to[index(0, by)];
            for (int bx = blocks.x0; bx <= blocks.x1; ++bx) {
                // Where the ray (dx, dy, 1) through the block's middle meets the disc's plane: at depth 1 /
                // w.
                const float dx = (middle_x(bx) - centre_x) * inverse_focal;
                const float w = n.x * dx + row_w;
                const float off_x = dx - p.x * w, off_y = dy - p.y * w, off_z = 1 - p.z * w;
                const bool is_met =
                    (w > 0) & (off_x * off_x + off_y * off_y + off_z * off_z <= radius2 * w * w);
                row[bx] = std::max(row[bx], is_met ? w - behind * w * w : 0.0f);
            }
        }
    }

    bool reaches_unproven(const Blocks& blocks) const {
        for (int by = blocks.y0; by <= blocks.y1; ++by)
            for (int bx = blocks.x0; bx <= blocks.x1; ++bx)
                if (unproven[index(bx, by)]) return true;
        return false;
    }

    void note(const Blocks& blocks, float limit) {
        has_hidden.store(true, std::memory_order_relaxed);
        const uint32_t bits = std::bit_cast<uint32_t>(limit);
        for (int by = blocks.y0; by <= blocks.y1; ++by)
            for (int bx = blocks.x0; bx <= blocks.x1; ++bx) {
                std::atomic_ref<uint32_t> to(limits[index(bx, by)]);
                uint32_t old = to.load(std::memory_order_relaxed);
                while (old < bits && !to.compare_exchange_weak(old, bits, std::memory_order_relaxed)) {
                }
            }
    }

    // No fragment of what is within the sphere has an inverse depth w or push p (see below) so that w + p is
    // above this.  A fragment's depth is between the points where its ray meets its splat, so w <= 1 / near
    // for near = z - radius.  Its push, the step in w from its splat's centre, at depth z' with z' - R >=
    // near, to its radius R behind it, is R / (z' (z' + R)) <= radius / near^2.  The hundredth covers what a
    // splat's plane may rise to a thousandth of its size beyond its outline, the rest what float is off by
    // and splats so small that they are drawn larger than they are (kMinRadiusPx of splat_setup.cpp).
    float limit_of(const glm::vec3& p, float radius) const {
        const float grown = 1.01f * radius, w = 1 / (p.z - grown);
        return w * (1 + grown * w) * (1 + 1e-4f + 0.02f / focal);
    }
};

OcclusionMap::OcclusionMap() : state_(std::make_unique<State>()) {}
OcclusionMap::~OcclusionMap() = default;

void OcclusionMap::begin(const View& view, double unit) {
    State& s = *state_;
    s.left = view.margins.left, s.top = view.margins.top;
    s.right = s.left + view.width, s.bottom = s.top + view.height;
    s.first_x = s.left / kBlock, s.first_y = s.top / kBlock;
    s.across = (s.right - 1) / kBlock + 1 - s.first_x, s.down = (s.bottom - 1) / kBlock + 1 - s.first_y;
    s.focal = float(view.focal_px);
    const glm::dvec2 principal = view.principal();
    s.centre_x = float(principal.x), s.centre_y = float(principal.y);
    s.near = float(view.near.value_or(0) / unit);
    const size_t blocks = size_t(s.across) * size_t(s.down);
    for (std::vector<float>& surfaces : s.surfaces) surfaces.assign(blocks, 0);
    s.limits.assign(blocks, 0);
    s.unproven.assign(blocks, 0);
    s.has_hidden = s.has_unproven = s.is_repeated = false;
}

void OcclusionMap::add_surfaces(std::span<const Surface> surfaces) {
    std::vector<float>& to = state_->surfaces.local();
    to.resize(state_->limits.size());
    for (const Surface& surface : surfaces) state_->add(surface, to);
}

void OcclusionMap::build() {
    State& s = *state_;
    s.nearest.resize(s.across, s.down);
    std::fill(s.nearest.w.begin(), s.nearest.w.end(), 0.0f);
    for (const std::vector<float>& surfaces : s.surfaces)
        for (size_t i = 0; i < surfaces.size(); ++i) s.nearest.w[i] = std::max(s.nearest.w[i], surfaces[i]);
    // A block is covered where its middle is and all those around it.
    erode(s.nearest, s.covers[0]);
    for (size_t n = 1; n < s.covers.size(); ++n) halve(s.covers[n - 1], s.covers[n]);
}

OcclusionMap::Sight OcclusionMap::look(const glm::vec3& p, float radius) {
    State& s = *state_;
    if (!(p.z > kClearRadii * radius)) return Sight::partly;
    if (s.is_repeated) return s.reaches_unproven(s.blocks_of(p, radius)) ? Sight::partly : Sight::hidden;
    if (!(2 * radius * s.focal >= kLeastDiameterPx * p.z)) return Sight::clear;
    const Blocks blocks = s.blocks_of(p, radius);
    if (blocks.is_empty()) return Sight::clear;
    const float limit = s.limit_of(p, radius), middle = 1 / p.z;
    const unsigned span = unsigned(std::max(blocks.x1 - blocks.x0, blocks.y1 - blocks.y0));
    const size_t n = std::min<size_t>(size_t(std::bit_width(span / 2)), s.covers.size() - 1);
    bool all = true, any = false;
    for (int y = blocks.y0 >> n; y <= blocks.y1 >> n; ++y) {
        const float* row = s.covers[n].row(y);
        for (int x = blocks.x0 >> n; x <= blocks.x1 >> n; ++x) {
            all = all && row[x] > limit;
            any = any || row[x] > middle;
        }
    }
    if (!all) return any ? Sight::partly : Sight::clear;
    s.note(blocks, limit);
    return Sight::hidden;
}

bool OcclusionMap::has_hidden() const {
    return state_->has_hidden;
}

float OcclusionMap::limit(int x, int y) const {
    return std::bit_cast<float>(state_->limits[state_->index_of_pixel(x, y)]);
}

void OcclusionMap::mark_unproven(int x, int y) {
    state_->unproven[state_->index_of_pixel(x, y)] = 1;
    state_->has_unproven.store(true, std::memory_order_relaxed);
}

bool OcclusionMap::is_unproven(int x, int y) const {
    return state_->unproven[state_->index_of_pixel(x, y)];
}
bool OcclusionMap::has_unproven() const {
    return state_->has_unproven;
}

void OcclusionMap::begin_repeat() {
    state_->is_repeated = true;
}
bool OcclusionMap::is_repeated() const {
    return state_->is_repeated;
}

}  // namespace geom
