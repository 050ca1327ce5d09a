#include "splat/build/errors.h"

#include <algorithm>
#include <tuple>

#include "core/stopwatch.h"
#include "splat/build/disc.h"

namespace splat {

namespace {

constexpr float kRoundUp = 1.0001f;  // over the float rounding of distances
constexpr float kVague = 0.2f;       // of the radius: a leaf's error above it is worth a second look
constexpr float kNear =
    0.5f;  // of their radii: parts that only graze a node's sphere cost time and say nothing
constexpr size_t kLowered = 64;     // leaves of a subtree; of 256 those beyond hardly ever matter
constexpr float kRounding = 1e-5f;  // of the radius: heights beside 0 are differences

}  // namespace

void set_error(CodedTree& tree, size_t node, float error) {
    const uint32_t flatness = tree.shape[node] & 3u,
                   code = encode_error(error, tree.decoded[node].radius, flatness);
    tree.attitude[node] = uint16_t((tree.attitude[node] & 0x7fffu) | code >> 2 << 15);
    tree.shape[node] = uint8_t(flatness | (code & 3u) << 2);
    tree.decoded[node].error = tree.decoded[node].radius * kErrorOfRadius[flatness][code];
}

float error_over(const Node& node, std::span<const Node* const> children) {
    return nested_error(node, children, true) * kRoundUp;
}

namespace {

class ErrorSetter {
  public:
    ErrorSetter(CodedTree& tree, Surface& surface, std::span<const uint32_t> leaf_of)
        : tree_(tree), surface_(surface), leaf_of_(leaf_of) {}

    double run() {
        gather_spheres();
        find_neighbours();
        core::ProcessorWatch watch;
        set_leaf_errors();
        const double leaf_ms = watch.lap_ms();
        for (uint32_t node = uint32_t(tree_.size()); node-- > 0;)
            if (!is_leaf(node)) tree_.decoded[node].error = inner_error(node);
        for (uint32_t node = uint32_t(tree_.size()); node-- > 0;)
            set_error(tree_, node, tree_.decoded[node].error);
        return leaf_ms;
    }

  private:
    bool is_leaf(uint32_t node) const { return tree_.child_group[node] == CodedTree::kLeaf; }
    // What is known of a node's surface: its children, or itself where it has none.
    NodeRange parts_of(uint32_t node) const {
        if (is_leaf(node)) return {node, 1};
        const auto [first, count] = tree_.groups[size_t(tree_.child_group[node])];
        return {first, count};
    }

    void gather_spheres() {
        const size_t room = tree_.size() + kSpare;
        for (auto* channel : {&spheres_.x, &spheres_.y, &spheres_.z, &spheres_.radius}) channel->resize(room);
        for (size_t node = 0; node < tree_.size(); ++node) {
            const Node& n = tree_.decoded[node];
            const glm::vec3 at(n.centre - surface_.base);
            spheres_.x[node] = at.x, spheres_.y[node] = at.y, spheres_.z[node] = at.z,
            spheres_.radius[node] = n.radius;
        }
    }

    // For each inner node the parts of the nodes of its level whose spheres touch its own, itself first.
    // These nodes are found among the parts of its parent's neighbours.
    void find_neighbours() {
        family_begin_.assign(tree_.size() + 1, 0);
        families_.clear();
        std::vector<uint32_t> parent(tree_.size(), 0);
        for (uint32_t node = 0; node < tree_.size(); ++node) {
            if (!is_leaf(node)) {
                const NodeRange own = parts_of(node);
                for (uint32_t k = 0; k < own.count; ++k) parent[own.first + k] = node;
                families_.push_back(own);
                if (node > 0)
                    for (const uint32_t n : touching(spheres_, families_of(parent[node]), node, 1, near_))
                        if (n != node) families_.push_back(parts_of(n));
            }
            family_begin_[node + 1] = uint32_t(families_.size());
        }
    }
    std::span<const NodeRange> families_of(uint32_t node) const {
        return std::span(families_).subspan(family_begin_[node],
                                            family_begin_[node + 1] - family_begin_[node]);
    }

    // The node's disc reaches over the rim of its surface, where its neighbours' is.
    float inner_error(uint32_t node) {
        const std::span<const NodeRange> families = families_of(node);
        parts_.clear();
        for (uint32_t k = 0; k < families[0].count; ++k)
            parts_.push_back(&tree_.decoded[families[0].first + k]);
        for (const uint32_t n : touching(spheres_, families.subspan(1), node, kNear, near_))
            parts_.push_back(&tree_.decoded[n]);
        return nested_error(tree_.decoded[node], parts_, false) * kRoundUp;
    }

    // Where a leaf's own faces say little its neighbours' discs say more: by what theirs have said.
    void set_leaf_errors() {
        std::vector<std::pair<uint32_t, float>> better;
        for (const CodedTree::Group& group : tree_.groups)
            surface_.has_triangles() ? set_triangle_errors(group) : set_group_errors(group);
        // Discs of triangles reach over their rims as far as those beside them do, and say little of these:
        // it would take half as long again to build, for errors of leaves that are 15 % smaller, and 2 %
        // those above.
        const bool asks_others = !surface_.has_triangles();
        for (uint32_t node = 0; node < tree_.size(); ++node) {
            if (is_leaf(node) || !asks_others) continue;
            const NodeRange children = parts_of(node);
            for (uint32_t c = children.first; c < children.first + children.count; ++c)
                if (is_leaf(c) && tree_.decoded[c].error > kVague * tree_.decoded[c].radius)
                    better.emplace_back(c, error_by_others(c, node));
        }
        for (const auto& [leaf, error] : better)
            tree_.decoded[leaf].error = std::min(tree_.decoded[leaf].error, error);
        if (asks_others) lower_largest();
    }

    // The bound of a frame is the largest error in it, and that of a few leaves, at rims mostly, may be
    // several times too large: other sheets of the surface are near that no edge leads to.  So the largest of
    // the subtree are held against all faces that are near.
    void lower_largest() {
        struct Vague {
            float error;
            uint32_t leaf, parent;
        };
        std::vector<Vague> vague;
        for (uint32_t node = 0; node < tree_.size(); ++node) {
            if (is_leaf(node)) continue;
            const NodeRange children = parts_of(node);
            for (uint32_t c = children.first; c < children.first + children.count; ++c)
                if (is_leaf(c) && tree_.decoded[c].error > kVague * tree_.decoded[c].radius)
                    vague.push_back({tree_.decoded[c].error, c, node});
        }
        const size_t count = std::min(kLowered, vague.size());
        std::partial_sort(vague.begin(), vague.begin() + ptrdiff_t(count), vague.end(),
                          [](const Vague& a, const Vague& b) {
                              return std::tie(b.error, a.leaf) < std::tie(a.error, b.leaf);
                          });
        for (size_t k = 0; k < count; ++k)
            tree_.decoded[vague[k].leaf].error =
                std::min(vague[k].error, error_by_faces(vague[k].leaf, vague[k].parent));
    }

    float error_by_faces(uint32_t leaf, uint32_t parent) {
        near_leaves_.assign(1, leaf_of_[leaf]);
        for (const uint32_t n : touching(spheres_, families_of(parent), leaf, 1, near_))
            if (n != leaf && is_leaf(n)) near_leaves_.push_back(leaf_of_[n]);
        const LeafDisc disc = disc_of(leaf);
        return (faces_error(surface_, disc, near_leaves_) + kRounding * disc.radius) * kRoundUp;
    }

    float error_by_others(uint32_t leaf, uint32_t parent) {
        parts_.clear();
        for (const uint32_t n : touching(spheres_, families_of(parent), leaf, 1, near_))
            if (n != leaf && is_leaf(n)) parts_.push_back(&tree_.decoded[n]);
        return nested_error(tree_.decoded[leaf], parts_, true) * kRoundUp;
    }

    void set_group_errors(const CodedTree::Group& group) {
        LeafDisc discs[kMaxFanOut];
        uint32_t nodes[kMaxFanOut];
        size_t count = 0;
        for (uint32_t node = group.first; node < group.first + group.count; ++node) {
            if (!is_leaf(node)) continue;
            discs[count] = disc_of(node);
            nodes[count++] = node;
        }
        float errors[kMaxFanOut];
        leaf_errors(surface_, {discs, count}, now_, errors);
        for (size_t k = 0; k < count; ++k) {
            const float radius = discs[k].radius,
                        to_vertex =
                            float(glm::length(surface_.at[discs[k].leaf] - discs[k].centre) + double(radius));
            tree_.decoded[nodes[k]].error = std::min(errors[k] + kRounding * radius, to_vertex) * kRoundUp;
        }
    }

    void set_triangle_errors(const CodedTree::Group& group) {
        for (uint32_t node = group.first; node < group.first + group.count; ++node) {
            if (!is_leaf(node)) continue;
            const LeafDisc disc = disc_of(node);
            tree_.decoded[node].error =
                (triangle_error(surface_, disc) + kRounding * disc.radius) * kRoundUp +
                surface_.triangles.rounding;
        }
    }

    LeafDisc disc_of(uint32_t leaf_node) const {
        const Node& n = tree_.decoded[leaf_node];
        return {leaf_of_[leaf_node], n.centre - surface_.base, frame_about(n.normal), n.radius,
                flatness_code(n)};
    }

    CodedTree& tree_;
    Surface& surface_;
    const std::span<const uint32_t> leaf_of_;
    uint32_t now_ = 0;  // for leaf_errors()
    Spheres spheres_;
    std::vector<uint32_t> family_begin_, near_;  // by node
    std::vector<uint32_t> near_leaves_;
    std::vector<NodeRange> families_;
    std::vector<const Node*> parts_;
};

}  // namespace

double set_errors(CodedTree& tree, Surface& surface, std::span<const uint32_t> leaf_of) {
    return ErrorSetter(tree, surface, leaf_of).run();
}

}  // namespace splat
