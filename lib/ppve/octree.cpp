#include "ppve/octree.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "core/error.h"
#include "core/parallel.h"

namespace ppve {

using core::text;

namespace {

using ull = unsigned long long;

constexpr ClusterId kRoot = 1;

int level_of(ClusterId id) {
    return (int(std::bit_width(id)) - 1) / 3;
}

// Which of a node's children holds the cell, of a tree of so many levels.
uint32_t octant_of(const glm::uvec3& cell, int level, int levels) {
    const int shift = levels - 1 - level;
    return (cell.x >> shift & 1) | (cell.y >> shift & 1) << 1 | (cell.z >> shift & 1) << 2;
}

uint64_t hash_of(const Cluster& cluster) {
    if (cluster.patches.empty()) return 0;
    std::vector<uint64_t> hashes;
    for (const auto& patch : cluster.patches) hashes.push_back(patch->hash());
    return XXH3_64bits_withSeed(hashes.data(), hashes.size() * sizeof(uint64_t), cluster.id);
}

std::shared_ptr<const Patch> make_patch(const std::shared_ptr<const Sampling>& sampling,
                                        const DepthImage& image, double unit,
                                        std::span<const uint32_t> pixels) {
    const auto world = [&](uint32_t pixel) {
        const int width = image.width();
        return position_of(image.frustum, image.coding, int(pixel) % width, int(pixel) / width,
                           image.depth[pixel]);
    };
    const auto nearest = std::max_element(pixels.begin(), pixels.end(), [&](uint32_t a, uint32_t b) {
        return image.depth[a] < image.depth[b];
    });
    const glm::dvec3 anchor = world(*nearest);
    const bool with_normals = !image.normal.empty();
    PatchPoints points;
    points.reserve(pixels.size(), with_normals);
    for (const uint32_t pixel : pixels) {
        const glm::vec3 offset((world(pixel) - anchor) / unit);
        points.x.push_back(offset.x);
        points.y.push_back(offset.y);
        points.z.push_back(offset.z);
        points.colour.push_back(image.colour[pixel]);
        if (with_normals) points.normal.push_back(image.normal[pixel]);
    }
    return std::make_shared<const Patch>(sampling, anchor, unit, std::move(points));
}

// The points of a patch for which keep(i) is true; null where there are none, the patch itself where all are.
template <class Keep>
std::shared_ptr<const Patch> part_of(const std::shared_ptr<const Patch>& patch, double unit,
                                     const Keep& keep) {
    PatchPoints points;
    const bool with_normals = patch->points().has_normals();
    for (size_t i = 0; i < patch->size(); ++i)
        if (keep(i)) points.take(patch->points(), i, with_normals);
    if (points.size() == 0) return nullptr;
    if (points.size() == patch->size()) return patch;
    return std::make_shared<const Patch>(patch->shared_sampling(), patch->anchor(), unit, std::move(points));
}

}  // namespace

void check(const TreeShape& shape) {
    const auto is_in_range = [](double v) { return std::fabs(v) <= 1e150; };
    for (int k = 0; k < 3; ++k)
        if (!is_in_range(shape.corner[k]))
            throw core::Error(text("octree: corner %g is not a coordinate up to 1e150", shape.corner[k]));
    if (!(shape.side >= 1e-150 && shape.side <= 1e150))
        throw core::Error(text("octree: side %g is not between 1e-150 and 1e150", shape.side));
    if (shape.levels < 0 || shape.levels > TreeShape::kMostLevels)
        throw core::Error(text("octree: %d levels, expected 0 to %d", shape.levels, TreeShape::kMostLevels));
    if (shape.leaf_points < 1) throw core::Error("octree: leaves without points");
}

size_t Cluster::points() const {
    size_t count = 0;
    for (const auto& patch : patches) count += patch->size();
    return count;
}

size_t Cluster::bytes() const {
    size_t bytes = 0;
    for (const auto& patch : patches) bytes += patch->bytes();
    return bytes;
}

TreeShape shape_around(const Box& bounds) {
    TreeShape shape;
    if (bounds.is_empty) return shape;
    const glm::dvec3 size = bounds.high - bounds.low, middle = bounds.low + 0.5 * size;
    const double longest = std::max({size.x, size.y, size.z});
    const double far_out = std::max({std::fabs(middle.x), std::fabs(middle.y), std::fabs(middle.z)});
    // Room for samples that rounding puts outside the box; and a point has some extent.
    shape.side = 1.01 * longest + 1e-12 * far_out;
    if (shape.side == 0) shape.side = 1;
    shape.corner = middle - 0.5 * shape.side;
    check(shape);
    return shape;
}

Octree::Octree(const TreeShape& shape) : shape_(shape) {
    check(shape);
    clear();
}

void Octree::clear() {
    nodes_.assign(1, {});
    nodes_[0].cluster.id = kRoot;
    free_.clear();
    checksum_ = points_ = patch_bytes_ = 0;
    clusters_ = 0;
}

void Octree::apply(const Change& change) {
    if (change.starts_anew) clear();
    for (const ClusterId id : change.obsolete)
        if (const uint32_t node = node_of(id); node != kNone) empty(node);
    for (const Removal& removal : change.removed) remove(removal);
    if (change.added) add(change.update, *change.added);
}

uint32_t Octree::node_of(ClusterId id) const {
    if (id == 0 || (std::bit_width(id) - 1) % 3 != 0) return kNone;
    uint32_t node = 0;
    for (int level = level_of(id); level > 0; --level) {
        if (nodes_[node].child == kNone) return kNone;
        node = nodes_[node].child + uint32_t(id >> 3 * (level - 1) & 7);
    }
    return nodes_[node].child == kNone ? node : kNone;
}

const Cluster* Octree::find(ClusterId id) const {
    const uint32_t node = node_of(id);
    return node == kNone || nodes_[node].cluster.patches.empty() ? nullptr : &nodes_[node].cluster;
}

void Octree::for_each(const std::function<void(const Cluster&)>& visit) const {
    std::vector<uint32_t> stack{0};
    while (!stack.empty()) {
        const Node& node = nodes_[stack.back()];
        stack.pop_back();
        if (node.child != kNone)
            for (uint32_t k = 8; k-- > 0;) stack.push_back(node.child + k);
        else if (!node.cluster.patches.empty())
            visit(node.cluster);
    }
}

glm::uvec3 Octree::cell_of(const glm::dvec3& world) const {
    const double cells = std::ldexp(1.0, shape_.levels);
    glm::uvec3 cell;
    for (int k = 0; k < 3; ++k) {
        // What lies outside the cube, by rounding or because it does, is in the cells at its border.
        const double at = (world[k] - shape_.corner[k]) / shape_.side * cells;
        cell[k] = at >= 1 ? static_cast<uint32_t>(std::min(at, cells - 1)) : 0;
    }
    return cell;
}

Octree::Leaf Octree::leaf_at(const glm::uvec3& cell) const {
    Leaf leaf{0, 0};
    for (; nodes_[leaf.node].child != kNone; ++leaf.level)
        leaf.node = nodes_[leaf.node].child + octant_of(cell, leaf.level, shape_.levels);
    return leaf;
}

void Octree::recount(uint32_t at, uint64_t points_before, uint64_t bytes_before) {
    Node& node = nodes_[at];
    const bool was_there = points_before > 0, is_there = !node.cluster.patches.empty();
    checksum_ -= node.hash;
    node.hash = hash_of(node.cluster);
    checksum_ += node.hash;
    clusters_ += size_t(is_there) - size_t(was_there);
    points_ += node.cluster.points() - points_before;
    patch_bytes_ += node.cluster.bytes() - bytes_before;
}

void Octree::empty(uint32_t at) {
    Cluster& cluster = nodes_[at].cluster;
    if (cluster.patches.empty()) return;
    const uint64_t points = cluster.points(), bytes = cluster.bytes();
    cluster.patches.clear();
    recount(at, points, bytes);
    join_empty(cluster.id >> 3);
}

// Else the tree's nodes would grow along with all that was ever seen.
void Octree::join_empty(ClusterId parent) {
    for (; parent != 0; parent >>= 3) {
        uint32_t node = 0;
        for (int level = level_of(parent); level > 0; --level)
            node = nodes_[node].child + uint32_t(parent >> 3 * (level - 1) & 7);
        const uint32_t first = nodes_[node].child;
        for (uint32_t k = 0; k < 8; ++k)
            if (nodes_[first + k].child != kNone || !nodes_[first + k].cluster.patches.empty()) return;
        nodes_[node].child = kNone;
        free_.push_back(first);
    }
}

void Octree::remove(const Removal& removal) {
    const uint32_t at = node_of(removal.cluster);
    if (at == kNone || removal.patch >= nodes_[at].cluster.patches.size())
        throw core::Error(text("octree: points of patch %u of cluster %llx are to go, which is not there",
                               removal.patch, ull(removal.cluster)));
    Cluster& cluster = nodes_[at].cluster;
    auto& patch = cluster.patches[removal.patch];
    if (removal.is_removed.size() != patch->size())
        throw core::Error(text("octree: of %zu points of patch %u of cluster %llx some are to go; it has %zu",
                               removal.is_removed.size(), removal.patch, ull(removal.cluster),
                               patch->size()));
    const uint64_t points = cluster.points(), bytes = cluster.bytes();
    patch = part_of(patch, shape_.unit(), [&](size_t i) { return removal.is_removed[i] == 0; });
    if (!patch) cluster.patches.erase(cluster.patches.begin() + removal.patch);
    recount(at, points, bytes);
    if (cluster.patches.empty()) join_empty(cluster.id >> 3);
}

// What is to be added, sample by sample: its pixel, its cell among those of the deepest level, and its leaf.
struct Octree::Sorting {
    std::vector<uint32_t> pixels;
    std::vector<glm::uvec3> cells;
    std::vector<Leaf> leaves;
};

void Octree::sort_by_leaf(const DepthImage& image, Sorting& sorting) const {
    for (size_t i = 0; i < image.depth.size(); ++i)
        if (image.depth[i] != 0) sorting.pixels.push_back(static_cast<uint32_t>(i));
    sorting.cells.resize(sorting.pixels.size());
    sorting.leaves.resize(sorting.pixels.size());
    core::parallel_pieces(sorting.pixels.size(), 4096, [&](size_t begin, size_t end) {
        const int width = image.width();
        for (size_t i = begin; i < end; ++i) {
            const int pixel = int(sorting.pixels[i]);
            sorting.cells[i] = cell_of(position_of(image.frustum, image.coding, pixel % width, pixel / width,
                                                   image.depth[size_t(pixel)]));
            sorting.leaves[i] = leaf_at(sorting.cells[i]);
        }
    });
}

// Whether any leaf was.  Called until none is, so that no point is moved twice.
bool Octree::split_overfull(Sorting& sorting) {
    std::vector<uint32_t> coming(nodes_.size());
    std::vector<Leaf> overfull;
    for (const Leaf& leaf : sorting.leaves)
        if (++coming[leaf.node] == 1) overfull.push_back(leaf);
    std::erase_if(overfull, [&](const Leaf& leaf) {
        return leaf.level >= shape_.levels ||
               coming[leaf.node] + nodes_[leaf.node].cluster.points() <= shape_.leaf_points;
    });
    for (const Leaf& leaf : overfull) split(leaf.node, leaf.level);
    if (overfull.empty()) return false;
    for (size_t i = 0; i < sorting.leaves.size(); ++i) {
        Leaf& leaf = sorting.leaves[i];
        if (const uint32_t child = nodes_[leaf.node].child; child != kNone)
            leaf = {child + octant_of(sorting.cells[i], leaf.level, shape_.levels), leaf.level + 1};
    }
    return true;
}

uint32_t Octree::take_children(uint32_t parent) {
    uint32_t first;
    if (!free_.empty()) {
        first = free_.back();
        free_.pop_back();
    } else {
        first = static_cast<uint32_t>(nodes_.size());
        nodes_.resize(nodes_.size() + 8);
    }
    for (uint32_t k = 0; k < 8; ++k) nodes_[first + k] = {kNone, {nodes_[parent].cluster.id << 3 | k, {}}, 0};
    nodes_[parent].child = first;
    return first;
}

void Octree::split(uint32_t at, int level) {
    const uint32_t first = take_children(at);
    const Cluster whole = std::move(nodes_[at].cluster);
    nodes_[at].cluster = {whole.id, {}};
    if (whole.patches.empty()) return;
    recount(at, whole.points(), whole.bytes());
    for (const auto& patch : whole.patches) {
        std::vector<uint8_t> octants(patch->size());
        for (size_t i = 0; i < patch->size(); ++i) octants[i] = octant_in(whole.id, level, *patch, i);
        for (uint8_t k = 0; k < 8; ++k)
            if (auto part = part_of(patch, shape_.unit(), [&](size_t i) { return octants[i] == k; }))
                nodes_[first + k].cluster.patches.push_back(std::move(part));
    }
    for (uint32_t k = 0; k < 8; ++k) recount(first + k, 0, 0);
}

// A point may have been rounded out of its leaf's cube: it goes to the nearest part of it.
uint8_t Octree::octant_in(ClusterId id, int level, const Patch& patch, size_t i) const {
    const PatchPoints& p = patch.points();
    const glm::uvec3 cell = cell_of(patch.anchor() + glm::dvec3(p.x[i], p.y[i], p.z[i]) * shape_.unit());
    glm::uvec3 low(0);
    for (int l = level; l-- > 0;)
        for (int k = 0; k < 3; ++k)
            low[k] |= static_cast<uint32_t>(id >> (3 * l + k) & 1) << (shape_.levels - level + l);
    const glm::uvec3 high = low + ((1u << (shape_.levels - level)) - 1);
    return static_cast<uint8_t>(octant_of(glm::clamp(cell, low, high), level, shape_.levels));
}

void Octree::add(uint64_t update, const DepthImage& image) {
    Sorting sorting;
    sort_by_leaf(image, sorting);
    while (split_overfull(sorting)) continue;

    // By leaf, and in a leaf by pixel.
    std::vector<uint32_t> slot_of(nodes_.size(), kNone), nodes;
    std::vector<std::vector<uint32_t>> pixels;
    for (size_t i = 0; i < sorting.leaves.size(); ++i) {
        uint32_t& slot = slot_of[sorting.leaves[i].node];
        if (slot == kNone) {
            slot = static_cast<uint32_t>(nodes.size());
            nodes.push_back(sorting.leaves[i].node);
            pixels.emplace_back();
        }
        pixels[slot].push_back(sorting.pixels[i]);
    }
    const auto sampling =
        std::make_shared<const Sampling>(Sampling{update, image.frustum, image.footprint_px});
    std::vector<std::shared_ptr<const Patch>> patches(nodes.size());
    core::parallel_for(nodes.size(), [&](size_t slot) {
        patches[slot] = make_patch(sampling, image, shape_.unit(), pixels[slot]);
    });
    for (size_t slot = 0; slot < nodes.size(); ++slot) {
        Cluster& cluster = nodes_[nodes[slot]].cluster;
        const uint64_t points = cluster.points(), bytes = cluster.bytes();
        cluster.patches.push_back(std::move(patches[slot]));
        recount(nodes[slot], points, bytes);
    }
}

}  // namespace ppve
