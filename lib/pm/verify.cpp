#include "pm/verify.h"

#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "pm/build/details.h"

namespace pm {

namespace {

unsigned long long number(uint64_t value) {
    return static_cast<unsigned long long>(value);
}

class Verifier {
  public:
    explicit Verifier(const Model& model) : model_(model), tree_(model.hierarchy()) {}

    VerifyCounts run() {
        check_bytes();
        check_depth();
        list_faces();
        check_base_faces();
        for_details([&](uint32_t d) { return fault_of_faces(d); });
        for_details([&](uint32_t d) { return fault_of_order(d); });
        check_edges();
        check_welds();
        group_faces_by_leaf();
        bound_leaves();
        check_bounds();
        VerifyCounts counts{model_.vertices(), faces_.size(), model_.details(), 0};
        for (const uint32_t d : tree_.needs) counts.dependencies += d != kNone;
        return counts;
    }

  private:
    [[noreturn]] void refuse(const std::string& what) const {
        throw core::Error(model_.name() + ": " + what);
    }

    // The first fault is named, whatever the number of threads.  fault_of(d) is null where there is none.
    template <class FaultOf>
    void for_details(const FaultOf& fault_of) const {
        std::atomic<uint32_t> first{model_.details()};
        core::parallel_for(
            model_.details(),
            [&](size_t i) {
                const auto d = uint32_t(i);
                if (d >= first || fault_of(d) == nullptr) return;
                for (uint32_t seen = first; d < seen && !first.compare_exchange_weak(seen, d);) {
                }
            },
            1024);
        if (first < model_.details()) refuse(core::text("detail %u %s", first.load(), fault_of(first)));
    }

    void check_bytes() const {
        const std::span<const std::byte> bytes = model_.content();
        const uint64_t hash = XXH3_64bits(bytes.data(), bytes.size());
        if (hash != model_.header().content_hash)
            refuse(core::text("content %016llx, its header says %016llx", number(hash),
                              number(model_.header().content_hash)));
        if (!model_.is_padding_zero()) refuse("what fills its sections up is not 0");
    }

    void check_depth() const {
        std::vector<uint32_t> depth(model_.details());
        uint32_t deepest = 0;
        for (uint32_t d = 0; d < model_.details(); ++d) {
            depth[d] = tree_.parent[d] == kNone ? 1 : depth[tree_.parent[d]] + 1;
            deepest = std::max(deepest, depth[d]);
        }
        if (deepest != model_.header().depth)
            refuse(core::text("a depth of %u, its header says %u", deepest, model_.header().depth));
    }

    void list_faces() {
        faces_.assign(tree_.base_faces.begin(), tree_.base_faces.end());
        for (const SplitFaces& added : tree_.faces)
            for (const glm::u32vec3& face : {added.left, added.right})
                if (face.x != kNone) faces_.push_back(face);
        if (faces_.size() != model_.header().faces)
            refuse(
                core::text("%zu faces, its header says %llu", faces_.size(), number(model_.header().faces)));
    }

    uint32_t root(uint32_t vertex) const {
        while (vertex >= tree_.base_vertices) vertex = tree_.kept[vertex - tree_.base_vertices];
        return vertex;
    }

    void check_base_faces() const {
        for (size_t f = 0; f < tree_.base_faces.size(); ++f) {
            const glm::u32vec3 roots(root(tree_.base_faces[f].x), root(tree_.base_faces[f].y),
                                     root(tree_.base_faces[f].z));
            if (roots.x == roots.y || roots.y == roots.z || roots.z == roots.x)
                refuse(core::text("base face %zu has two corners below one root", f));
        }
    }

    // A face whose corners (fresh, kept, cut) are those of the detail that adds it.
    bool is_added_by(uint32_t d, uint32_t fresh, uint32_t kept, uint32_t cut) const {
        if (fresh == kept || kept == cut || cut == fresh) return false;
        if (split_apart(tree_, fresh, kept) != d || !is_below(fresh, tree_.born_by(d))) return false;
        // The cut parted from both before.  kNone: another tree.
        const uint32_t apart = split_apart(tree_, cut, kept);
        return apart == kNone || apart < d;
    }

    bool is_below(uint32_t vertex, uint32_t ancestor) const {
        while (vertex > ancestor) vertex = tree_.kept[vertex - tree_.base_vertices];
        return vertex == ancestor;
    }

    const char* fault_of_faces(uint32_t d) const {
        const auto [left, right] = tree_.faces[d];
        if (left.x != kNone && !is_added_by(d, left.x, left.y, left.z))
            return "adds a left face that another one adds";
        if (right.x != kNone && !is_added_by(d, right.y, right.x, right.z))
            return "adds a right face that another one adds";
        return nullptr;
    }

    const char* fault_of_order(uint32_t d) const {
        const SplitFaces& faces = tree_.faces[d];
        const bool has_both = faces.left.x != kNone && faces.right.x != kNone;
        uint32_t apart = kNone;
        if (has_both) {
            if (faces.left_cut() == faces.right_cut()) return "has one cut twice";
            apart = split_apart(tree_, faces.left_cut(), faces.right_cut());
        }
        const uint32_t needs = apart == kNone || is_ancestor(tree_, apart, d) ? kNone : apart;
        if (tree_.needs[d] != needs) return "needs another detail than its cuts do";
        for (const uint32_t on : {tree_.parent[d], tree_.needs[d]})
            if (on != kNone && model_.error_code(d) > model_.error_code(on))
                return "has a larger error than what it depends on";
        return nullptr;
    }

    void check_edges() const {
        std::vector<uint64_t> edges;
        edges.reserve(3 * faces_.size());
        for (const glm::u32vec3& f : faces_)
            for (int k = 0; k < 3; ++k) edges.push_back(uint64_t(f[k]) << 32 | f[(k + 1) % 3]);
        std::sort(edges.begin(), edges.end());
        if (const auto twice = std::adjacent_find(edges.begin(), edges.end()); twice != edges.end())
            refuse(core::text("the edge from vertex %u to %u is that of two faces", uint32_t(*twice >> 32),
                              uint32_t(*twice)));
    }

    void check_welds() const {
        for (size_t w = 0; w < model_.welds().size(); ++w) {
            const Weld weld = model_.welds()[w];
            if (weld.copy == weld.of || model_.unit(weld.copy) != model_.unit(weld.of))
                refuse(core::text("weld %zu is not of two vertices in one place", w));
        }
    }

    // The faces about every leaf.
    void group_faces_by_leaf() {
        fan_begin_.assign(size_t(model_.vertices()) + 2, 0);
        for (const glm::u32vec3& f : faces_)
            for (int k = 0; k < 3; ++k) ++fan_begin_[size_t(f[k]) + 2];
        for (size_t v = 2; v < fan_begin_.size(); ++v) fan_begin_[v] += fan_begin_[v - 1];
        fan_.resize(3 * faces_.size());
        for (uint32_t f = 0; f < faces_.size(); ++f)
            for (int k = 0; k < 3; ++k) fan_[fan_begin_[size_t(faces_[f][k]) + 1]++] = f;
        normals_.resize(faces_.size());
        core::parallel_for(
            faces_.size(),
            [&](size_t f) {
                const glm::dvec3 a = model_.unit(faces_[f].x), b = model_.unit(faces_[f].y),
                                 c = model_.unit(faces_[f].z);
                const glm::dvec3 n = glm::cross(b - a, c - a);
                const double length = glm::length(n);
                normals_[f] = length > 0 ? n / length : glm::dvec3(0);
            },
            4096);
    }

    // Of the faces about each leaf, so that most leaves need no look at them.
    void bound_leaves() {
        leaves_.resize(model_.vertices());
        core::parallel_for(
            leaves_.size(), [&](size_t v) { leaves_[v] = bounded_leaf(uint32_t(v)); }, 1024);
    }

    struct Leaf {
        glm::dvec3 at{0};
        double radius = 0;                       // about `at`
        glm::dvec3 axis{0};                      // of a cone of their normals
        double least_cosine = 2, most_sine = 0;  // of its half angle; 2: they have no normals
    };

    Leaf bounded_leaf(uint32_t v) const {
        Leaf leaf;
        leaf.at = model_.unit(v);
        glm::dvec3 sum{0};
        for_faces_about(v, [&](uint32_t f) {
            for (int k = 0; k < 3; ++k)
                leaf.radius = std::max(leaf.radius, glm::length(model_.unit(faces_[f][k]) - leaf.at));
            sum += normals_[f];
        });
        if (sum == glm::dvec3(0)) return leaf;
        leaf.axis = glm::normalize(sum);
        for_faces_about(v, [&](uint32_t f) {
            if (normals_[f] != glm::dvec3(0))
                leaf.least_cosine = std::min(leaf.least_cosine, glm::dot(leaf.axis, normals_[f]));
        });
        leaf.most_sine = std::sqrt(std::max(0.0, 1 - leaf.least_cosine * leaf.least_cosine));
        return leaf;
    }

    template <class Use>
    void for_faces_about(uint32_t leaf, const Use& use) const {
        for (uint32_t i = fan_begin_[leaf]; i < fan_begin_[leaf + 1]; ++i) use(fan_[i]);
    }

    // A detail's node as it is tested: wider by more than rounding.
    struct Bound {
        explicit Bound(const NodeBounds& node)
            : centre(node.centre),
              radius(decode_radius(node.radius) * (1 + kRounding)),
              has_cone(node.cone.angle < kAnyDirection),
              cone(decode_cone(node.cone.axis, node.cone.angle)) {}

        bool holds_sphere(const Leaf& leaf) const {
            return glm::length(leaf.at - centre) + leaf.radius <= radius;
        }

        // The leaf's cone is in this one where its axis is nearer than the half angles differ.
        bool holds_cone(const Leaf& leaf) const {
            if (!has_cone) return true;
            return leaf.least_cosine >= cone.cosine && leaf.least_cosine <= 1 &&
                   glm::dot(cone.axis, leaf.axis) >=
                       cone.cosine * leaf.least_cosine + cone.sine * leaf.most_sine;
        }

        bool holds_point(const glm::dvec3& p) const { return glm::length(p - centre) <= radius; }
        bool holds_normal(const glm::dvec3& n) const {
            return !has_cone || n == glm::dvec3(0) || glm::dot(cone.axis, n) >= cone.cosine - kRounding;
        }

        static constexpr double kRounding = 1e-9;
        glm::dvec3 centre;
        double radius;
        bool has_cone;
        Cone cone;
    };

    const char* fault_of_leaf(const Bound& bound, uint32_t v) const {
        const char* fault = nullptr;
        const Leaf& leaf = leaves_[v];
        if (!bound.holds_sphere(leaf))
            for_faces_about(v, [&](uint32_t f) {
                for (int k = 0; k < 3; ++k)
                    if (!bound.holds_point(model_.unit(faces_[f][k])))
                        fault = "has a sphere that does not hold its surface";
            });
        if (fault == nullptr && !bound.holds_cone(leaf))
            for_faces_about(v, [&](uint32_t f) {
                if (!bound.holds_normal(normals_[f])) fault = "has a cone that does not hold its normals";
            });
        return fault;
    }

    // Leaves below a detail's node, by a walk over its splits.
    const char* fault_of_bounds(uint32_t detail, std::vector<uint32_t>& stack) const {
        const Bound bound(model_.bounds(detail));
        if (const char* fault = fault_of_leaf(bound, tree_.kept[detail])) return fault;
        stack.assign(1, detail);
        while (!stack.empty()) {
            const uint32_t d = stack.back();
            stack.pop_back();
            if (const char* fault = fault_of_leaf(bound, tree_.born_by(d))) return fault;
            const Children below = model_.children()[d];
            if (below.kept != kNone) stack.push_back(below.kept);
            if (below.fresh != kNone) stack.push_back(below.fresh);
        }
        return nullptr;
    }

    void check_bounds() const {
        for_details([&](uint32_t d) {
            thread_local std::vector<uint32_t> stack;
            return fault_of_bounds(d, stack);
        });
    }

    const Model& model_;
    Hierarchy tree_;
    std::vector<glm::u32vec3> faces_;
    std::vector<uint32_t> fan_begin_, fan_;
    std::vector<glm::dvec3> normals_;  // of the faces; 0 without area
    std::vector<Leaf> leaves_;         // by vertex
};

}  // namespace

VerifyCounts verify(const Model& model) {
    return Verifier(model).run();
}

}  // namespace pm
