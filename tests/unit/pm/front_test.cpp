#include "pm/front.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "test_models.h"

namespace {

using namespace pm_test;

// The face oracle: the faces of the fully refined mesh whose leaf corners have three distinct active
// ancestors, by an explicit tree of nodes: roots are 0 .. B - 1, the children of detail d are B + 2d (kept)
// and B + 2d + 1 (new).
class Oracle {
  public:
    explicit Oracle(const pm::Model& model) : model_(model), tree_(model.hierarchy()) {
        const uint32_t roots = tree_.base_vertices;
        std::vector<uint32_t> node(tree_.vertices());  // by vertex: its latest
        std::iota(node.begin(), node.begin() + roots, 0u);
        up_.assign(roots + 2 * size_t(tree_.details()), pm::kNone);
        split_by_.assign(up_.size(), pm::kNone);
        for (uint32_t d = 0; d < tree_.details(); ++d) {
            const uint32_t split = node[tree_.kept[d]];
            split_by_[split] = d;
            node[tree_.kept[d]] = roots + 2 * d;
            node[tree_.born_by(d)] = roots + 2 * d + 1;
            up_[roots + 2 * d] = up_[roots + 2 * d + 1] = split;
        }
        leaf_ = node;
        pm::Front full(tree_);
        std::vector<uint32_t> all(tree_.details());
        std::iota(all.begin(), all.end(), 0u);
        full.assign(all);
        faces_ = full.faces();
    }

    uint32_t vertex_of(uint32_t node) const {
        const uint32_t roots = tree_.base_vertices;
        if (node < roots) return node;
        const uint32_t d = (node - roots) / 2;
        return (node - roots) % 2 ? tree_.born_by(d) : tree_.kept[d];
    }

    std::vector<glm::u32vec3> faces(const pm::Front& front) const {
        std::vector<glm::u32vec3> result;
        for (const glm::u32vec3& f : faces_) {
            const glm::u32vec3 at(active(f.x, front), active(f.y, front), active(f.z, front));
            if (at.x != at.y && at.y != at.z && at.z != at.x)
                result.emplace_back(vertex_of(at.x), vertex_of(at.y), vertex_of(at.z));
        }
        return result;
    }

  private:
    // The highest node above the leaf that is not split.
    uint32_t active(uint32_t leaf, const pm::Front& front) const {
        uint32_t highest = leaf_[leaf];
        for (uint32_t node = leaf_[leaf]; node != pm::kNone; node = up_[node])
            if (split_by_[node] == pm::kNone || !front.is_split(split_by_[node])) highest = node;
        return highest;
    }

    const pm::Model& model_;
    pm::Hierarchy tree_;
    std::vector<uint32_t> up_, split_by_, leaf_;
    std::vector<glm::u32vec3> faces_;
};

void walk(pm::Front& front, uint32_t details, Random& random, double bias, int steps) {
    for (int s = 0; s < steps; ++s) {
        const auto d = uint32_t(random.bits() % details);
        if (random.unit() < bias) {
            if (front.can_split(d)) front.split(d);
        } else if (front.can_collapse(d)) {
            front.collapse(d);
        }
    }
}

bool has_edge_twice(const std::vector<glm::u32vec3>& faces) {
    std::set<std::pair<uint32_t, uint32_t>> edges;
    for (const glm::u32vec3& f : faces)
        for (int k = 0; k < 3; ++k)
            if (!edges.emplace(f[k], f[(k + 1) % 3]).second) return true;
    return false;
}

struct Topology {
    int64_t euler = 0;
    size_t boundary_edges = 0;
};

Topology topology_of(const std::vector<glm::u32vec3>& faces, size_t vertices) {
    std::set<std::pair<uint32_t, uint32_t>> directed, edges;
    for (const glm::u32vec3& f : faces)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = f[k], b = f[(k + 1) % 3];
            directed.emplace(a, b);
            edges.emplace(std::min(a, b), std::max(a, b));
        }
    Topology t;
    t.euler = int64_t(vertices) - int64_t(edges.size()) + int64_t(faces.size());
    t.boundary_edges = 2 * edges.size() - directed.size();
    return t;
}

TEST(Front, OfARandomWalkIsTheOraclesFaces) {
    Random random(11);
    std::vector<NamedMesh> shapes;
    for (NamedMesh& shape : all_shapes())
        if (build_model(shape.mesh).details() > 10) shapes.push_back(std::move(shape));
    const int walks_each = 1000 / int(shapes.size()) + 1;
    for (const NamedMesh& shape : shapes) {
        const pm::Model model = build_model(shape.mesh);
        const Oracle oracle(model);
        pm::Front front(model.hierarchy());
        const int64_t euler = topology_of(front.faces(), front.vertices().size()).euler;
        for (int w = 0; w < walks_each; ++w) {
            walk(front, model.details(), random, 0.2 + 0.7 * random.unit(), 60 + int(random.bits() % 200));
            const auto faces = front.faces();
            ASSERT_EQ(faces.size(), front.face_count()) << shape.name;
            ASSERT_EQ(sorted(faces), sorted(oracle.faces(front))) << shape.name << ", walk " << w;
            ASSERT_FALSE(has_edge_twice(faces)) << shape.name << ", walk " << w;
            ASSERT_EQ(topology_of(faces, front.vertices().size()).euler, euler)
                << shape.name << ", walk " << w;
        }
    }
}

TEST(Front, AnyOrderToTheSameSetIsTheSameMesh) {
    const pm::Model model = build_model(splat_test::bumpy_torus(12, 30));
    Random random(12);
    for (int round = 0; round < 20; ++round) {
        pm::Front target(model.hierarchy()), other(model.hierarchy());
        walk(target, model.details(), random, 0.7, 800);
        walk(other, model.details(), random, 0.8, 900);
        const auto wanted = [&](uint32_t d) { return target.is_split(d); };
        // Collapses from the last on, splits from the first on, each where it is legal, until nothing is left
        // to do.
        for (uint32_t d = model.details(); d-- > 0;)
            if (!wanted(d) && other.can_collapse(d)) other.collapse(d);
        for (uint32_t d = 0; d < model.details(); ++d)
            if (wanted(d) && other.can_split(d)) other.split(d);
        EXPECT_EQ(other.faces(), target.faces());
        std::vector<uint32_t> set;
        for (uint32_t d = 0; d < model.details(); ++d)
            if (wanted(d)) set.push_back(d);
        pm::Front assigned(model.hierarchy());
        assigned.assign(set);
        EXPECT_EQ(assigned.faces(), target.faces());
        EXPECT_EQ(assigned.split_count(), target.split_count());
    }
}

TEST(Front, CoarsensToTheBaseMeshWithEveryLegalCollapse) {
    Random random(13);
    for (const NamedMesh& shape : all_shapes()) {
        const pm::Model model = build_model(shape.mesh);
        if (model.details() == 0) continue;
        pm::Front front(model.hierarchy());
        walk(front, model.details(), random, 0.8, 3000);
        for (uint32_t left = front.split_count(); left > 0;) {
            for (uint32_t i = 0; i < model.details(); ++i) {
                const auto d = uint32_t((i * 7919ull) % model.details());
                if (front.can_collapse(d)) front.collapse(d);
            }
            ASSERT_LT(front.split_count(), left) << shape.name;
            left = front.split_count();
        }
        EXPECT_EQ(front.faces(), pm::Front(model.hierarchy()).faces()) << shape.name;
    }
}

// If `needs` were not asked for, faces would lie on each other: what the paper's loop over cut vertices
// prevents.
TEST(Front, WithoutNeedsHasAnEdgeTwice) {
    const pm::Model model = build_model(splat_test::bumpy_torus(24, 60));
    pm::Hierarchy loose = model.hierarchy();
    const std::vector<uint32_t> none(model.details(), pm::kNone);
    loose.needs = none;
    Random random(14);
    bool was_broken = false;
    for (int round = 0; round < 50 && !was_broken; ++round) {
        pm::Front front(loose);
        walk(front, model.details(), random, 0.8, 2000);
        was_broken = has_edge_twice(front.faces());
    }
    EXPECT_TRUE(was_broken);
}

TEST(Front, KeepsItsStateWhenTheHierarchyGrows) {
    const pm::Model model = build_model(splat_test::icosphere(2));
    const pm::Hierarchy whole = model.hierarchy();
    pm::Hierarchy part = whole;
    const uint32_t half = whole.details() / 2;
    part.kept = whole.kept.first(half), part.parent = whole.parent.first(half),
    part.needs = whole.needs.first(half);
    part.faces = whole.faces.first(half);
    pm::Front front(whole), grown(part);
    for (uint32_t d = 0; d < whole.details(); ++d)
        if (front.can_split(d)) front.split(d);
    for (uint32_t d = 0; d < half; ++d) grown.split(d);
    grown.grow(whole);
    EXPECT_EQ(grown.split_count(), half);
    for (uint32_t d = half; d < whole.details(); ++d) grown.split(d);
    EXPECT_EQ(grown.faces(), front.faces());
}

TEST(Front, EveryPrefixOfTheFileIsLegal) {
    for (const NamedMesh& shape : all_shapes()) {
        const pm::Model model = build_model(shape.mesh);
        pm::Front front(model.hierarchy());
        for (uint32_t d = 0; d < model.details(); ++d) {
            ASSERT_TRUE(front.can_split(d)) << shape.name;
            front.split(d);
        }
        EXPECT_EQ(front.face_count(), model.header().faces);
    }
}

}  // namespace
