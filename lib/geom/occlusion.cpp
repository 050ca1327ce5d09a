#include "geom/occlusion.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <vector>

#include "geom/occlusion_blocks.h"

namespace geom {
namespace {

using Level = std::vector<float>;  // inverse depths by block, or by square of blocks; 0: nothing there

// The least of each block and the eight around it, into rows that are `stride` apart.
void erode(const Level& from, int across, int down, int stride, float* to) {
    Level least(size_t(across) + 2);  // of three rows, with a border
    for (int y = 0; y < down; ++y) {
        const auto row = [&](int at) { return from.data() + size_t(at) * size_t(across); };
        const float* above = row(std::max(y - 1, 0));
        const float* here = row(y);
        const float* below = row(std::min(y + 1, down - 1));
        for (int x = 0; x < across; ++x)
            least[size_t(x) + 1] = std::min(std::min(above[x], below[x]), here[x]);
        least.front() = least[1], least.back() = least[size_t(across)];
        float* out = to + size_t(y) * size_t(stride);
        for (int x = 0; x < across; ++x)
            out[x] = std::min(std::min(least[size_t(x)], least[size_t(x) + 2]), least[size_t(x) + 1]);
    }
}

// The least of the four squares `size` blocks across that make up each of twice the size.
void double_squares(const float* from, int across, int down, int stride, int size, float* to) {
    for (int y = 0; y < down; ++y) {
        const float* above = from + size_t(y) * size_t(stride);
        const float* below = from + size_t(y + size < down ? y + size : y) * size_t(stride);
        float* out = to + size_t(y) * size_t(stride);
        for (int x = 0; x < across; ++x)
            out[x] = std::min(std::min(above[x], above[x + size]), std::min(below[x], below[x + size]));
    }
}

}  // namespace

struct OcclusionMap::State {
    BlockGrid grid;
    // By thread: the nearest surface in the middle of each block, and what cover_blocks() needs beyond the
    // last.
    tbb::enumerable_thread_specific<Level> surfaces;
    Level nearest;
    std::vector<float> squares;
    Covers covers;                 // what surely covers, as far as surfaces tell: of `squares`
    std::vector<uint32_t> limits;  // bits of floats, which order as the floats: none is negative
    std::vector<uint8_t> unproven;
    std::atomic<bool> has_hidden{false}, has_unproven{false};
    bool is_repeated = false;

    size_t index_of_pixel(int x, int y) const {
        return grid.index(x / kBlock - grid.first_x, y / kBlock - grid.first_y);
    }

    void begin_covers() {
        covers.stride = grid.across + Covers::kPad;
        covers.level_size = covers.stride * grid.down;
        // What is beyond the picture covers everything: nothing of it is seen.
        squares.assign(size_t(Covers::kLevels) * size_t(covers.level_size),
                       std::numeric_limits<float>::infinity());
        for (int n = 0; n < Covers::kLevels; ++n) covers.level[n] = squares.data() + n * covers.level_size;
    }

    // A body(index) for each block of the box, until one is true.
    template <class Body>
    bool any_block(const SphereBlocks& blocks, size_t i, const Body& body) const {
        for (int by = blocks.y0[i]; by <= blocks.y1[i]; ++by)
            for (int bx = blocks.x0[i]; bx <= blocks.x1[i]; ++bx)
                if (body(grid.index(bx, by))) return true;
        return false;
    }

    void note(const SphereBlocks& blocks, size_t i, float limit) {
        has_hidden.store(true, std::memory_order_relaxed);
        const uint32_t bits = std::bit_cast<uint32_t>(limit);
        any_block(blocks, i, [&](size_t block) {
            std::atomic_ref<uint32_t> to(limits[block]);
            uint32_t old = to.load(std::memory_order_relaxed);
            while (old < bits && !to.compare_exchange_weak(old, bits, std::memory_order_relaxed)) {
            }
            return false;
        });
    }

    void look_again(const Spheres& spheres, Sight* sights) const {
        SphereBlocks blocks;
        find_blocks(grid, spheres, blocks);
        for (size_t i = 0; i < spheres.count; ++i) {
            const bool is_near = !(spheres.z[i] > kClearRadii * spheres.radius[i]);
            const bool reaches =
                is_near || any_block(blocks, i, [&](size_t block) { return unproven[block] != 0; });
            sights[i] = reaches ? Sight::partly : Sight::hidden;
        }
    }
};

OcclusionMap::OcclusionMap() : state_(std::make_unique<State>()) {}
OcclusionMap::~OcclusionMap() = default;

void OcclusionMap::begin(const View& view, double unit) {
    State& s = *state_;
    BlockGrid& g = s.grid;
    g.left = view.margins.left, g.top = view.margins.top;
    g.right = g.left + view.width, g.bottom = g.top + view.height;
    g.first_x = g.left / kBlock, g.first_y = g.top / kBlock;
    g.across = (g.right - 1) / kBlock + 1 - g.first_x, g.down = (g.bottom - 1) / kBlock + 1 - g.first_y;
    g.focal = float(view.focal_px);
    const glm::dvec2 principal = view.principal();
    g.centre_x = float(principal.x), g.centre_y = float(principal.y);
    g.near = float(view.near.value_or(0) / unit);
    for (Level& surfaces : s.surfaces) surfaces.assign(g.count() + kBlocksBeyond, 0);
    s.begin_covers();
    s.limits.assign(g.count(), 0);
    s.unproven.assign(g.count(), 0);
    s.has_hidden = s.has_unproven = s.is_repeated = false;
}

void OcclusionMap::add_surfaces(std::span<const Surface> surfaces) {
    Level& to = state_->surfaces.local();
    to.resize(state_->grid.count() + kBlocksBeyond);
    cover_blocks(state_->grid, surfaces, to.data());
}

void OcclusionMap::build() {
    State& s = *state_;
    const BlockGrid& g = s.grid;
    s.nearest.assign(g.count(), 0);
    for (const Level& surfaces : s.surfaces)
        for (size_t i = 0; i < g.count(); ++i) s.nearest[i] = std::max(s.nearest[i], surfaces[i]);
    // A block is covered where its middle is and all those around it.
    const auto level = [&](int n) { return s.squares.data() + n * s.covers.level_size; };
    erode(s.nearest, g.across, g.down, s.covers.stride, level(0));
    for (int n = 1; n < Covers::kLevels; ++n)
        double_squares(level(n - 1), g.across, g.down, s.covers.stride, 1 << (n - 1), level(n));
}

void OcclusionMap::look(const Spheres& spheres, Sight* sights) {
    State& s = *state_;
    if (s.is_repeated) return s.look_again(spheres, sights);
    Looked looked;
    look_at(s.grid, s.covers, spheres, looked);
    for (size_t i = 0; i < spheres.count; ++i) {
        sights[i] = Sight(looked.sights[i]);
        if (sights[i] == Sight::hidden) s.note(looked.blocks, i, looked.limits[i]);
    }
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
