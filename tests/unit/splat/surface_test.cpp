#include "splat/build/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "test_meshes.h"

using namespace splat_test;

namespace {

constexpr double kTolerance = 1e-6;  // of meshes of size 1, in single precision
constexpr int kDirections = 100;

// The surface about all leaves of a mesh, and its faces as leaves.
struct Gathered {
    explicit Gathered(const mesh::Mesh& mesh) {
        for (const glm::vec3& position : mesh.positions)
            points.push_back({position, uint32_t(points.size())});
        splat::sort_into_tree(points);
        std::vector<uint32_t> leaf_of(points.size());
        for (uint32_t leaf = 0; leaf < points.size(); ++leaf) leaf_of[points[leaf].vertex] = leaf;
        for (const glm::u32vec3& face : mesh.triangles)
            faces.emplace_back(leaf_of[face.x], leaf_of[face.y], leaf_of[face.z]);
        splat::SubtreeInput input;
        input.end = uint32_t(points.size());
        input.points = points, input.faces = faces;
        surface = splat::gather_surface(input);
    }
    glm::dvec3 place(uint32_t leaf) const { return surface.at[leaf]; }
    glm::dvec3 corner(uint32_t leaf, uint32_t k) const {
        return place(leaf) + glm::dvec3(surface.corners.get(k));
    }
    uint32_t begin(uint32_t leaf) const { return surface.corner_begin[leaf]; }
    uint32_t rim_end(uint32_t leaf) const { return surface.rim_end[leaf]; }
    uint32_t end(uint32_t leaf) const { return surface.corner_begin[leaf + 1]; }

    std::vector<splat::TreePoint> points;
    std::vector<glm::u32vec3> faces;
    splat::Surface surface;
};

std::vector<glm::dvec3> directions() {
    Random random(3);
    std::vector<glm::dvec3> directions(kDirections);
    for (glm::dvec3& direction : directions) direction = random.direction();
    return directions;
}

// How far a leaf's corners from `begin` to `end` reach in a direction.
double reach(const Gathered& g, const glm::dvec3& direction, uint32_t leaf, uint32_t begin, uint32_t end) {
    double most = -std::numeric_limits<double>::infinity();
    for (uint32_t k = begin; k < end; ++k) most = std::max(most, glm::dot(direction, g.corner(leaf, k)));
    return most;
}

// There are corners behind the rims, and none is beyond what its siblings' rims reach.
void check_rims(const Gathered& g) {
    size_t inner = 0, beyond = 0;
    const uint32_t siblings = uint32_t(splat::kMaxFanOut);
    for (uint32_t first = 0; first < g.surface.count; first += siblings) {
        const uint32_t last = std::min(first + siblings, g.surface.count);
        for (const glm::dvec3& direction : directions()) {
            double rims = -std::numeric_limits<double>::infinity();
            for (uint32_t leaf = first; leaf < last; ++leaf)
                rims = std::max(rims, reach(g, direction, leaf, g.begin(leaf), g.rim_end(leaf)));
            for (uint32_t leaf = first; leaf < last; ++leaf) {
                inner += g.end(leaf) - g.rim_end(leaf);
                beyond += reach(g, direction, leaf, g.rim_end(leaf), g.end(leaf)) > rims + kTolerance;
            }
        }
    }
    EXPECT_GT(inner, 0u);
    EXPECT_EQ(beyond, 0u);
}

// Every point of a face is held by the corners of the leaf that it is nearest to.
void check_shares(const Gathered& g) {
    Random random(5);
    size_t outside = 0;
    const std::vector<glm::dvec3> all = directions();
    for (const glm::u32vec3& face : g.faces)
        for (int sample = 0; sample < 10; ++sample) {
            double s = random.unit(), t = random.unit();
            if (s + t > 1) s = 1 - s, t = 1 - t;
            const glm::dvec3 a = g.place(face.x);
            const glm::dvec3 p = a + s * (g.place(face.y) - a) + t * (g.place(face.z) - a);
            uint32_t nearest = face.x;
            for (const uint32_t leaf : {face.y, face.z})
                if (glm::distance(p, g.place(leaf)) < glm::distance(p, g.place(nearest))) nearest = leaf;
            for (const glm::dvec3& direction : all)
                outside += glm::dot(direction, p) >
                           reach(g, direction, nearest, g.begin(nearest), g.end(nearest)) + kTolerance;
        }
    EXPECT_EQ(outside, 0u);
}

TEST(Surface, BehindTheRimIsWithinTheHullOfTheSiblingsRims) {
    for (const NamedMesh& named :
         {NamedMesh{"torus", bumpy_torus(40, 20)}, {"terrain", terrain(30)}, {"ball", icosphere(3)}}) {
        SCOPED_TRACE(named.name);
        check_rims(Gathered(named.mesh));
    }
}

// Four leaves, all of them siblings: the rims are the leaves themselves.
TEST(Surface, OfSiblingsAloneHasNoMoreThanTheLeavesOnItsRims) {
    const Gathered g(tetrahedron());
    for (uint32_t leaf = 0; leaf < g.surface.count; ++leaf) {
        EXPECT_EQ(g.rim_end(leaf) - g.begin(leaf), 1u);
        EXPECT_EQ(g.surface.corners.get(g.begin(leaf)), glm::vec3(0));
    }
    check_rims(g);
}

TEST(Surface, OfEachLeafHoldsThePointsThatAreNearestToIt) {
    for (const NamedMesh& named : {NamedMesh{"torus", bumpy_torus(30, 15)},
                                   {"terrain", terrain(20)},
                                   {"ball", icosphere(2)},
                                   {"soup", soup(200)}}) {
        SCOPED_TRACE(named.name);
        check_shares(Gathered(named.mesh));
    }
}

}  // namespace
