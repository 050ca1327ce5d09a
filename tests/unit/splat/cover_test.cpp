// The two promises of a cut, as decoded: it covers the surface, and it is nowhere further from it than it
// says.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>

#include "core/parallel.h"
#include "mesh/distance.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

constexpr double kInside = 1e-6;  // of a splat's radius

// Which levels' cuts cover a point, found from the root down: an ellipsoid is inside the culling spheres of
// all nodes above it (NodeCode.NestsForAnyBitPattern).
class CoverSearch {
  public:
    // off: how far what is covered may be from the point, model units.
    CoverSearch(const Tree& tree, uint32_t levels, double off = 0)
        : tree_(tree), levels_(levels), off_(off) {}

    // First level whose cut leaves the point bare, or -1.
    int first_bare_level(const glm::dvec3& p) {
        covered_.assign(levels_ + 1, false);
        visit(0, p);
        for (uint32_t l = 0; l <= levels_; ++l)
            if (!covered_[l]) return int(l);
        return -1;
    }

  private:
    void visit(uint32_t i, const glm::dvec3& p) {
        const splat::Node& node = tree_.nodes[i];
        const double reach = (1 + double(splat::kSlack)) * double(node.radius) * (1 + 1e-5);
        if (glm::length(p - node.centre) > reach + off_) return;
        if (is_inside(node, p, kInside + off_ / double(node.flatness * node.radius))) {
            const uint32_t last = node.children == 0 ? levels_ : tree_.level[i];
            for (uint32_t l = tree_.level[i]; l <= last; ++l) covered_[l] = true;
        }
        for (uint32_t k = 0; k < uint32_t(node.children); ++k) visit(tree_.first_child[i] + k, p);
    }

    const Tree& tree_;
    uint32_t levels_;
    double off_;
    std::vector<bool> covered_;
};

// Where in the triangle a sample lies: corners and edges too, where shares meet.
std::array<double, 3> sample_weights(Random& random, int k) {
    if (k < 3) return {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
    double u = random.unit(), v = k < 6 ? 0 : random.unit();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const double w[3] = {u, v, 1 - u - v};
    return {w[k % 3], w[(k + 1) % 3], w[(k + 2) % 3]};
}

void expect_covered_by(splat::Leaf leaf, const std::string& name, const mesh::Mesh& mesh, int samples) {
    const splat::Model model = build_model(mesh, {.leaf = leaf});
    const Tree tree = read_tree(model);
    const splat::Header& h = model.header();
    // What triangle leaves cover are the triangles as the lattice has them.
    const double off = h.has_triangles() ? std::ldexp(0.87, -int(h.lattice_bits)) : 0;
    const auto place = [&](uint32_t v) {
        return (mesh.origin - h.origin + glm::dvec3(mesh.positions[v])) / h.scale;
    };
    std::atomic<uint64_t> bare{0}, total{0};
    std::mutex mutex;
    std::string first;
    core::parallel_pieces(mesh.triangles.size(), 1024, [&](size_t begin, size_t end) {
        CoverSearch search(tree, h.level_count, off);
        Random random(begin + 1);
        for (size_t f = begin; f < end; ++f)
            for (int k = 0; k < samples; ++k) {
                const auto w = sample_weights(random, k);
                const glm::u32vec3 t = mesh.triangles[f];
                const glm::dvec3 p = w[0] * place(t.x) + w[1] * place(t.y) + w[2] * place(t.z);
                ++total;
                const int level = search.first_bare_level(p);
                if (level < 0) continue;
                const std::scoped_lock lock(mutex);
                if (bare++ == 0)
                    first = "face " + std::to_string(f) + ", sample " + std::to_string(k) + ", level " +
                            std::to_string(level);
            }
    });
    EXPECT_EQ(bare, 0u) << name << ": of " << total << " points; first: " << first;
    EXPECT_GT(total, 0u);
}

void expect_covered(const std::string& name, const mesh::Mesh& mesh, int samples) {
    expect_covered_by(splat::Leaf::point, name, mesh, samples);
}
void expect_covered_by_triangles(const std::string& name, const mesh::Mesh& mesh, int samples) {
    expect_covered_by(splat::Leaf::triangle, name, mesh, samples);
}

// The worst distance of random points on the discs of all nodes, by their error bounds; 1 is on the bound.
struct Excess {
    double worst = 0;
    size_t node = 0;
    uint64_t broken = 0;
};

Excess measure_errors(splat::Leaf leaf, const mesh::Mesh& mesh, int samples) {
    const splat::Model model = build_model(mesh, {.leaf = leaf});
    const Tree tree = read_tree(model);
    const splat::Header& h = model.header();
    const mesh::SurfaceDistance surface(mesh);
    Excess excess;
    std::mutex mutex;
    const double rounding = 1e-14 * (glm::length(h.origin) / h.scale + 1);
    core::parallel_pieces(tree.nodes.size(), 256, [&](size_t begin, size_t end) {
        Random random(begin + 1);
        Excess here;
        for (size_t i = begin; i < end; ++i) {
            const splat::Node& node = tree.nodes[i];
            const splat::Frame frame = splat::frame_about(node.normal);
            for (int k = 0; k < samples; ++k) {
                const double phi = 2 * std::numbers::pi * random.unit();
                const double r =
                    double(node.radius) * (k % 2 == 0 ? 1.0 : std::sqrt(random.unit()));  // the rim; inside
                const glm::dvec3 p = node.centre + r * (std::cos(phi) * glm::dvec3(frame.t1) +
                                                        std::sin(phi) * glm::dvec3(frame.t2));
                const double distance =
                    surface.distance(h.origin + h.scale * p, std::numeric_limits<double>::infinity()) /
                    h.scale;
                const double ratio = (distance - rounding) / double(node.error);
                if (ratio > 1) ++here.broken;
                if (ratio > here.worst) here.worst = ratio, here.node = i;
            }
        }
        const std::scoped_lock lock(mutex);
        excess.broken += here.broken;
        if (here.worst > excess.worst) excess.worst = here.worst, excess.node = here.node;
    });
    return excess;
}

// The bounds of a model's largest leaf errors by what their discs' rims reach, sorted.
std::vector<double> bounds_by_reach(const mesh::Mesh& mesh, size_t count) {
    const splat::Model model = build_model(mesh);
    const splat::Header& h = model.header();
    std::vector<splat::Node> leaves = read_tree(model).nodes;
    std::erase_if(leaves, [](const splat::Node& node) { return node.children > 0; });
    std::sort(leaves.begin(), leaves.end(), [](const auto& a, const auto& b) { return a.error > b.error; });
    leaves.resize(std::min(leaves.size(), count));
    const mesh::SurfaceDistance surface(mesh);
    std::vector<double> ratios;
    for (const splat::Node& leaf : leaves) {
        const splat::Frame frame = splat::frame_about(leaf.normal);
        double reach = 0;
        for (int k = 0; k < 64; ++k) {
            const float phi = 2 * std::numbers::pi_v<float> * float(k) / 64;
            const glm::dvec3 across = std::cos(phi) * frame.t1 + std::sin(phi) * frame.t2;
            const glm::dvec3 p = h.origin + h.scale * (leaf.centre + double(leaf.radius) * across);
            reach = std::max(reach, surface.distance(p, std::numeric_limits<double>::infinity()) / h.scale);
        }
        ratios.push_back(double(leaf.error) / reach);
    }
    std::sort(ratios.begin(), ratios.end());
    return ratios;
}

void expect_bounded_by(splat::Leaf leaf, const std::string& name, const mesh::Mesh& mesh, int samples) {
    const Excess excess = measure_errors(leaf, mesh, samples);
    EXPECT_LE(excess.worst, 1.0) << name << ": node " << excess.node << ", " << excess.broken
                                 << " points beyond the bound";
    EXPECT_GT(excess.worst, 0.3) << name << ": the bound says nothing";
}

void expect_bounded(const std::string& name, const mesh::Mesh& mesh, int samples) {
    expect_bounded_by(splat::Leaf::point, name, mesh, samples);
}
void expect_bounded_of_triangles(const std::string& name, const mesh::Mesh& mesh, int samples) {
    expect_bounded_by(splat::Leaf::triangle, name, mesh, samples);
}

void for_real_mesh(const char* file, void (*check)(const std::string&, const mesh::Mesh&, int), int samples) {
    const mesh::Mesh mesh = shared_mesh(file);
    if (mesh.positions.empty()) GTEST_SKIP() << file << " is not there";
    check(file, mesh, samples);
}

}  // namespace

TEST(Cut, CoversEveryTriangleAtEveryLevel) {
    for (const NamedMesh& m : generated_meshes()) expect_covered(m.name, m.mesh, 24);
}

TEST(Cut, CoversTheBunnyAtEveryLevel) {
    for_real_mesh("bunny.ply", expect_covered, 10);
}
TEST(Cut, CoversTheArmadilloAtEveryLevel) {
    for_real_mesh("armadillo.ply", expect_covered, 8);
}

TEST(Cut, CoversEveryTriangleAtEveryLevelWithTrianglesAsLeaves) {
    for (const NamedMesh& m : generated_meshes()) expect_covered_by_triangles(m.name, m.mesh, 24);
}
TEST(Cut, CoversTheBunnyWithTrianglesAsLeaves) {
    for_real_mesh("bunny.ply", expect_covered_by_triangles, 6);
}

TEST(Cut, CoversEveryPointOfACloud) {
    const mesh::Mesh mesh = cloud(5000);
    const splat::Model model = build_model(mesh);
    const Tree tree = read_tree(model);
    CoverSearch search(tree, model.header().level_count);
    for (const glm::vec3& p : mesh.positions)
        ASSERT_EQ(search.first_bare_level((glm::dvec3(p) - model.header().origin) / model.header().scale),
                  -1);
}

TEST(ErrorBound, HoldsForEveryNodeOfEveryLevel) {
    for (const NamedMesh& m : generated_meshes()) expect_bounded(m.name, m.mesh, 32);
}

TEST(ErrorBound, HoldsForEveryNodeOfTheBunny) {
    for_real_mesh("bunny.ply", expect_bounded, 8);
}
TEST(ErrorBound, HoldsForEveryNodeOfTheArmadillo) {
    for_real_mesh("armadillo.ply", expect_bounded, 6);
}
TEST(ErrorBound, HoldsToThePointsOfACloud) {
    expect_bounded("cloud", cloud(5000), 16);
}

// By what edges lead to alone, 1.89 of the needles, 1.68 of the soup and 4.03 of the torus.
TEST(ErrorBound, OfTheLargestLeavesIsByAllFacesNear) {
    const std::vector<double> needles = bounds_by_reach(needle_fan(1000), 64);
    EXPECT_LT(needles[needles.size() * 9 / 10], 1.6);
    const std::vector<double> triangles = bounds_by_reach(soup(300), 64);
    EXPECT_LT(triangles[triangles.size() / 2], 1.6);
    EXPECT_LT(bounds_by_reach(bumpy_torus(30, 60), 64).back(), 3);
}

TEST(ErrorBound, HoldsForEveryNodeAboveTriangles) {
    for (const NamedMesh& m : generated_meshes()) expect_bounded_of_triangles(m.name, m.mesh, 24);
}
TEST(ErrorBound, HoldsForEveryNodeAboveTrianglesOfTheBunny) {
    for_real_mesh("bunny.ply", expect_bounded_of_triangles, 6);
}
