#include "splat/errors.h"

#include <algorithm>

#include "splat/disc.h"

namespace splat {

namespace {

constexpr float kRoundUp = 1.0001f;    // over the float rounding of distances
constexpr float kRounding = 1e-5f;     // of the radius: heights beside 0 are differences

uint32_t quantise_error(float error, float radius) {
    for (uint32_t code = 0; code < 8; ++code)
        if (error <= radius * kErrorOfRadius[code]) return code;
    return 7;
}

}  // namespace

void set_error(CodedTree& tree, size_t node, float error) {
    const uint32_t code = quantise_error(error, tree.decoded[node].radius);
    tree.attitude[node] = uint16_t((tree.attitude[node] & 0x7fffu) | code >> 2 << 15);
    tree.shape[node] = uint8_t((tree.shape[node] & 3u) | (code & 3u) << 2);
    tree.decoded[node].error = tree.decoded[node].radius * kErrorOfRadius[code];
}

float error_over(const Node& node, std::span<const Node* const> parts) {
    constexpr size_t kMost = 64;
    const Frame frame = frame_about(node.normal);
    ChildShape shapes[kMost];
    const auto turn = [&](const glm::vec3& v) {
        return glm::vec3(glm::dot(frame.t1, v), glm::dot(frame.t2, v), glm::dot(frame.n, v));
    };
    const size_t count = std::min(parts.size(), kMost);
    for (size_t k = 0; k < count; ++k) {
        const Node& c = *parts[k];
        shapes[k] = {turn(glm::vec3(c.centre - node.centre)), turn(c.normal), c.radius, c.error};
    }
    return nested_error(node.radius, {shapes, count}) * kRoundUp;
}

namespace {

class ErrorSetter {
  public:
    ErrorSetter(CodedTree& tree, const Surface& surface, std::span<const uint32_t> leaf_of)
        : tree_(tree), surface_(surface), leaf_of_(leaf_of) {}

    void run() {
        find_neighbours();
        for (size_t node = tree_.size(); node-- > 0;) {
            const bool is_leaf = tree_.child_group[node] == CodedTree::kLeaf;
            set_error(tree_, node, is_leaf ? leaf_error(leaf_of_[node], tree_.decoded[node]) : inner_error(node));
        }
    }

  private:
    template <class Use>
    void for_children(size_t node, const Use& use) const {
        if (tree_.child_group[node] == CodedTree::kLeaf) return;
        const auto [first, n] = tree_.groups[size_t(tree_.child_group[node])];
        for (uint32_t k = 0; k < n; ++k) use(first + k);
    }

    bool touch(size_t a, size_t b) const {
        const Node &p = tree_.decoded[a], &q = tree_.decoded[b];
        const glm::vec3 d(p.centre - q.centre);
        const float reach = p.radius + q.radius;
        return glm::dot(d, d) < reach * reach;
    }

    // For each inner node the nodes of its level whose spheres touch its own, itself first: found among the
    // children of its parent's neighbours.
    void find_neighbours() {
        neighbour_begin_.assign(tree_.size() + 1, 0);
        neighbours_.clear();
        const auto close = [&](size_t node) { neighbour_begin_[node + 1] = uint32_t(neighbours_.size()); };
        neighbours_.push_back(0);
        close(0);
        std::vector<uint32_t> parent(tree_.size(), 0);
        for (uint32_t node = 0; node < tree_.size(); ++node) for_children(node, [&](uint32_t c) { parent[c] = node; });
        for (uint32_t node = 1; node < tree_.size(); ++node) {
            if (tree_.child_group[node] != CodedTree::kLeaf) {
                neighbours_.push_back(node);
                for (uint32_t k = neighbour_begin_[parent[node]]; k < neighbour_begin_[parent[node] + 1]; ++k) {
                    const uint32_t uncle = neighbours_[k];
                    for_children(uncle, [&](uint32_t c) {
                        if (c != node && touch(c, node)) neighbours_.push_back(c);
                    });
                }
            }
            close(node);
        }
    }

    // The node's disc reaches over the rim of its surface, where its neighbours' is.
    float inner_error(size_t node) {
        parts_.clear();
        for (uint32_t k = neighbour_begin_[node]; k < neighbour_begin_[node + 1]; ++k) {
            const uint32_t n = neighbours_[k];
            for_children(n, [&](uint32_t c) {
                if (n == node || touch(c, node)) parts_.push_back(&tree_.decoded[c]);
            });
        }
        return error_over(tree_.decoded[node], parts_);
    }

    // Bound on the distance from any point of a leaf's disc to the surface.
    //
    // The faces about a set of closed vertices are taken, beginning with the leaf's own, until no edge of
    // their rim crosses the disc.  If all of them are seen from the normal's side, their projection covers
    // the whole disc (its degree over the disc is constant, and positive at the vertex), so that over each
    // point of the disc there is surface, no further up or down than the faces that meet the disc go.
    // Where the faces do not close or fold over, it is the distance to the faces at the vertex.
    float leaf_error(uint32_t i, const Node& node) {
        constexpr size_t kMostVertices = 16, kMostFaces = 64;
        const glm::dvec3 centre = node.centre - surface_.base;
        const float to_vertex = float(glm::length(surface_.at[i] - centre) + double(node.radius)) * kRoundUp;
        const Disc disc{frame_about(node.normal), node.radius};
        const auto fan_of = [&](uint32_t vertex) {
            return Fan{&surface_.fan_p, &surface_.fan_q, surface_.fan_begin[vertex], surface_.fan_begin[vertex + 1],
                       glm::vec3(surface_.at[vertex] - centre)};
        };
        const auto by_own_faces = [&] { return std::min(fan_error(fan_of(i), disc) * kRoundUp, to_vertex); };
        float height = 0;
        patch_.assign(1, i);
        for (size_t at = 0; at < patch_.size(); ++at) {
            const uint32_t vertex = patch_[at];
            if (vertex >= surface_.count || !surface_.is_closed[vertex]) return by_own_faces();
            if (patch_.size() > kMostVertices || surface_.valence(vertex) > kMostFaces) return by_own_faces();
            FanView fan = view_fan(fan_of(vertex), disc);
            if (fan.is_folded) return by_own_faces();
            height = std::max(height, fan.height);
            const auto has = [&](uint32_t x) { return std::find(patch_.begin(), patch_.end(), x) != patch_.end(); };
            for (; fan.crossing; fan.crossing &= fan.crossing - 1) {
                const glm::u32vec2 edge = surface_.fan[surface_.fan_begin[vertex] + uint32_t(__builtin_ctzll(fan.crossing))];
                if (!has(edge.x) && !has(edge.y)) patch_.push_back(edge.x);
            }
        }
        return std::min(height * kRoundUp + kRounding * node.radius, to_vertex);
    }

    CodedTree& tree_;
    const Surface& surface_;
    const std::span<const uint32_t> leaf_of_;
    std::vector<uint32_t> neighbour_begin_, neighbours_, patch_;
    std::vector<const Node*> parts_;
};

}  // namespace

void set_errors(CodedTree& tree, const Surface& surface, std::span<const uint32_t> leaf_of) {
    ErrorSetter(tree, surface, leaf_of).run();
}

}  // namespace splat
