// The point model of a session: a level-limited octree whose leaves are clusters of point patches.
//
// Ge et al. 2006, sections 4.4 and 4.5.  Client and server hold one each, and every change of it, be it new
// points, obsolete clusters or samples that finer ones replace, is in an update that the server decides and
// sends (Change).  So the tree is a function of the updates alone, and the same on both sides by
// construction; checksum() finds out where it is not.  In the paper each side deletes by itself, at a time of
// its own.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "ppve/patch.h"
#include "ppve/sampler.h"

namespace ppve {

// A leaf's number: a leading 1, then for each level three bits, z y x, that say which half of its parent's
// cube it is (the upper half: 1).  It follows from the place of its cube alone.  The root is 1.
using ClusterId = uint64_t;

// What both sides must agree on before the first update.
struct TreeShape {
    static constexpr int kMostLevels = 20;  // ClusterId holds 21

    glm::dvec3 corner{-1};  // of the root's cube, that of the least coordinates
    double side = 2;        // of the cube, world units
    int levels = 10;        // no leaf is deeper; 0: one cluster only
    // A leaf that holds more is cut.  Few points a patch cost time, many blur the level of detail.
    uint32_t leaf_points = 16384;

    // Of all coordinates in patches.
    double unit() const { return side; }
};

// Throws core::Error where the shape cannot be one: not finite, no size, levels or points out of range.
void check(const TreeShape& shape);

// The cube of a scene, the same on both sides: somewhat larger than the longest side of the box, about its
// middle.  Throws core::Error for a box that is not finite.
TreeShape shape_around(const Box& bounds);

// Points that are to leave a patch.  Of several patches of a cluster the last goes first, as a patch that is
// left without points goes, too.
struct Removal {
    ClusterId cluster = 0;
    uint32_t patch = 0;               // index in the cluster
    std::vector<uint8_t> is_removed;  // for each point of the patch, 0 or 1
};

// What an update does to the tree, in this order.
struct Change {
    bool starts_anew = false;         // all clusters go first
    std::vector<ClusterId> obsolete;  // these go; those that are not there are passed over
    std::vector<Removal> removed;
    uint64_t update = 0;                // number of what is added
    const DepthImage* added = nullptr;  // null: nothing
};

struct Cluster {
    ClusterId id = 0;
    std::vector<std::shared_ptr<const Patch>> patches;  // in the order in which they came; none is empty

    size_t points() const;
    size_t bytes() const;  // of memory, of the patches
};

class Octree {
  public:
    explicit Octree(const TreeShape& shape);  // checked

    // Throws core::Error where a removal does not fit the tree: a cluster or patch that is not there, a count
    // of points that differs.  Then the sides are out of step and the tree is as it may be, but safe to use.
    // Parallel; the same tree for any number of threads.  Some 15 ns a sample.
    void apply(const Change& change);

    const TreeShape& shape() const { return shape_; }
    const Cluster* find(ClusterId id) const;  // null where there is no such leaf, or it is empty

    // All that are not empty, in the order of their cubes along a Morton curve.
    void for_each(const std::function<void(const Cluster&)>& visit) const;

    uint64_t checksum() const { return checksum_; }  // 0 for an empty tree
    uint64_t points() const { return points_; }
    // Of memory: patches and the tree.
    uint64_t bytes() const { return patch_bytes_ + nodes_.capacity() * sizeof(Node); }
    size_t clusters() const { return clusters_; }

  private:
    static constexpr uint32_t kNone = 0xffffffff;

    // Inner: `child` is the first of eight.  Leaf: `child` is kNone.
    struct Node {
        uint32_t child = kNone;
        Cluster cluster;
        uint64_t hash = 0;  // of the cluster, as it counts in the checksum
    };
    struct Leaf {
        uint32_t node;
        int level;
    };
    struct Sorting;  // samples by leaf

    void clear();
    uint32_t node_of(ClusterId id) const;
    Leaf leaf_at(const glm::uvec3& cell) const;
    glm::uvec3 cell_of(const glm::dvec3& world) const;
    void empty(uint32_t node);
    void remove(const Removal& removal);
    void add(uint64_t update, const DepthImage& image);
    void sort_by_leaf(const DepthImage& image, Sorting& sorting) const;
    bool split_overfull(Sorting& sorting);
    void split(uint32_t node, int level);
    uint8_t octant_in(ClusterId id, int level, const Patch& patch, size_t i) const;
    uint32_t take_children(uint32_t parent);
    void join_empty(ClusterId parent);
    void recount(uint32_t node, uint64_t points_before, uint64_t bytes_before);

    TreeShape shape_;
    std::vector<Node> nodes_;
    std::vector<uint32_t> free_;  // first ones of eight
    uint64_t checksum_ = 0, points_ = 0, patch_bytes_ = 0;
    size_t clusters_ = 0;
};

}  // namespace ppve
