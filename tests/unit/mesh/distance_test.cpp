#include "mesh/distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/parallel.h"

namespace {

using mesh::Mesh;
using mesh::SurfaceDistance;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Wide = glm::vec<3, long double>;

// Ericson.  Real-time collision detection.  2005, section 5.1.5; in long double, by the regions of the
// corners and sides, and so by another way than the code under test.
Wide closest_on_triangle(const Wide& p, const Wide& a, const Wide& b, const Wide& c) {
    const Wide ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const long double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const long double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const long double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
    const long double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const long double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
    const long double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    return a + (vb * ab + vc * ac) / (va + vb + vc);
}

double brute_force(const Mesh& mesh, const glm::dvec3& world_point) {
    const Wide p = Wide(world_point) - Wide(mesh.origin);
    long double best = std::numeric_limits<long double>::infinity();
    if (mesh.is_cloud()) {
        for (const glm::vec3& v : mesh.positions) best = std::min(best, glm::length(p - Wide(v)));
    }
    for (const glm::u32vec3& t : mesh.triangles) {
        const Wide a(mesh.positions[t[0]]), b(mesh.positions[t[1]]), c(mesh.positions[t[2]]);
        best = std::min(best, glm::length(p - closest_on_triangle(p, a, b, c)));
    }
    return double(best);
}

struct Randoms {
    std::mt19937 engine;
    explicit Randoms(uint32_t seed) : engine(seed) {}
    double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
    glm::dvec3 point(double reach) { return {in(-reach, reach), in(-reach, reach), in(-reach, reach)}; }
    uint32_t below(size_t count) {
        return uint32_t(std::uniform_int_distribution<size_t>(0, count - 1)(engine));
    }
};

// Small triangles strewn in a cube, a few large ones, needles, and repeated corners.
Mesh strewn_mesh(size_t triangles, double scale, uint32_t seed) {
    Randoms random(seed);
    Mesh mesh;
    for (size_t t = 0; t < triangles; ++t) {
        const uint32_t at = uint32_t(mesh.positions.size());
        const glm::dvec3 middle = random.point(1);
        const double size = t % 17 == 0 ? 1.0 : 0.05;
        const glm::dvec3 along = random.point(size);
        mesh.positions.push_back(scale * middle);
        mesh.positions.push_back(scale * (middle + along));
        const bool needle = t % 5 == 0;
        mesh.positions.push_back(scale *
                                 (middle + (needle ? 0.5 * along + random.point(1e-4) : random.point(size))));
        mesh.triangles.push_back({at, at + 1, at + 2});
        if (t % 11 == 0) mesh.triangles.back()[2] = at + 1;     // a segment
        if (t % 23 == 0) mesh.triangles.back() = {at, at, at};  // a point
    }
    return mesh;
}

// Queries far off, near, and on the surface.
void check_against_brute_force(const Mesh& mesh, double scale, uint32_t seed, int count) {
    const SurfaceDistance surface(mesh);
    Randoms random(seed);
    for (int i = 0; i < count; ++i) {
        glm::dvec3 p = mesh.origin + scale * random.point(i % 3 == 0 ? 20 : 1.2);
        if (i % 3 == 1) p = mesh.world(random.below(mesh.positions.size())) + scale * random.point(1e-3);
        const double expected = brute_force(mesh, p);
        const double tolerance = 1e-12 * (scale + expected) + 1e-15 * glm::length(mesh.origin);
        ASSERT_NEAR(surface.distance(p, kInfinity), expected, tolerance) << "query " << i;
        ASSERT_NEAR(surface.distance(p, 1.01 * expected + 4 * tolerance), expected, tolerance)
            << "query " << i;
        ASSERT_EQ(surface.distance(p, 0.99 * expected - 2 * tolerance), kInfinity) << "query " << i;
    }
}

TEST(SurfaceDistance, AgreesWithBruteForce) {
    for (const size_t triangles : {1, 2, 4, 5, 8, 9, 13, 100, 2000}) {
        SCOPED_TRACE(triangles);
        check_against_brute_force(strewn_mesh(triangles, 1, uint32_t(triangles)), 1, 99, 300);
    }
}

TEST(SurfaceDistance, HoldsAtAnyScale) {
    for (const double scale : {1e-30, 1e-20, 1e-6, 1e6, 1e20, 1e30}) {
        SCOPED_TRACE(scale);
        check_against_brute_force(strewn_mesh(300, scale, 5), scale, 6, 200);
    }
}

TEST(SurfaceDistance, HoldsFarFromTheOrigin) {
    for (const double offset : {1e3, 1e7, 1e12}) {
        SCOPED_TRACE(offset);
        Mesh mesh = strewn_mesh(300, 1, 7);
        mesh.origin = {offset, -offset, 0.5 * offset};
        check_against_brute_force(mesh, 1, 8, 200);
    }
}

TEST(SurfaceDistance, HoldsInAMixOfScalesWithAnOutlier) {
    Mesh mesh = strewn_mesh(200, 1, 9);
    const Mesh small = strewn_mesh(200, 1e-6, 10);
    for (const glm::u32vec3& t : small.triangles)
        mesh.triangles.push_back(t + uint32_t(mesh.positions.size()));
    mesh.positions.insert(mesh.positions.end(), small.positions.begin(), small.positions.end());
    mesh.triangles.push_back({0, 1, uint32_t(mesh.positions.size())});
    mesh.positions.push_back({1e30f, 0, 0});
    const SurfaceDistance surface(mesh);
    Randoms random(11);
    for (int i = 0; i < 300; ++i) {
        const glm::dvec3 p = random.point(i % 2 ? 1.0 : 1e-6);
        const double expected = brute_force(mesh, p);
        ASSERT_NEAR(surface.distance(p, kInfinity), expected, 1e-12 * (1 + expected)) << i;
    }
}

TEST(SurfaceDistance, ACloudIsItsPoints) {
    for (const size_t points : {1, 3, 4, 5, 1000}) {
        Randoms random{uint32_t(points)};
        Mesh cloud;
        for (size_t i = 0; i < points; ++i) cloud.positions.push_back(random.point(1));
        check_against_brute_force(cloud, 1, 12, 200);
    }
}

TEST(SurfaceDistance, ManyEqualPointsAreNoTrouble) {
    Mesh cloud;
    cloud.positions.assign(100000, {1, 2, 3});
    const SurfaceDistance surface(cloud);
    EXPECT_EQ(surface.distance({1, 2, 3}, kInfinity), 0);
    EXPECT_EQ(surface.distance({1, 2, 8}, kInfinity), 5);
}

// Points over a needle in the plane z = 0, whose distance is their height.
TEST(SurfaceDistance, IsExactOverSlivers) {
    Randoms random(13);
    for (const float width : {1e-3f, 1e-6f, 1e-8f, 1e-9f, 1e-12f, 1e-20f, 0.0f}) {
        Mesh mesh;
        mesh.positions = {{0, 0, 0}, {0.9f, 0.4f, 0}, {-0.4f * width, 0.9f * width, 0}};
        mesh.triangles = {{0, 1, 2}};
        const SurfaceDistance surface(mesh);
        for (int i = 0; i < 500; ++i) {
            double u = random.in(0, 1), v = random.in(0, 1);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            glm::dvec3 p = u * glm::dvec3(mesh.positions[1]) + v * glm::dvec3(mesh.positions[2]);
            p.z = std::pow(10.0, random.in(-12, 1));
            const double found = surface.distance(p, kInfinity);
            ASSERT_GE(found, p.z * (1 - 1e-15)) << "width " << width;
            ASSERT_LE(found, p.z + 1e-8 * width + 1e-15) << "width " << width << " at " << u << "," << v;
        }
    }
}

TEST(SurfaceDistance, ADistanceFoundIsALimitThatFindsIt) {
    const Mesh mesh = strewn_mesh(500, 1, 14);
    const SurfaceDistance surface(mesh);
    Randoms random(15);
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 p = random.point(2);
        const double d = surface.distance(p, kInfinity);
        ASSERT_EQ(surface.distance(p, d), d);
        ASSERT_EQ(surface.distance(p, std::nextafter(d, 0.0)), kInfinity);
    }
}

TEST(SurfaceDistance, WhatIsNotThereIsInfinitelyFar) {
    const SurfaceDistance nothing{Mesh()};
    EXPECT_EQ(nothing.distance({0, 0, 0}, kInfinity), kInfinity);
    const SurfaceDistance surface(strewn_mesh(50, 1, 16));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double bad : {nan, kInfinity, -kInfinity}) {
        EXPECT_EQ(surface.distance({bad, 0, 0}, kInfinity), kInfinity);
        EXPECT_EQ(surface.distance({0, 0, bad}, 1.0), kInfinity);
    }
    EXPECT_EQ(surface.distance({0, 0, 0}, -1.0), kInfinity);
    EXPECT_EQ(surface.distance({0, 0, 0}, nan), kInfinity);
}

TEST(SurfaceDistance, VerticesWithoutTrianglesDoNotCount) {
    Mesh mesh = strewn_mesh(50, 1, 17);
    mesh.positions.push_back({30, 0, 0});
    EXPECT_GT(SurfaceDistance(mesh).distance({30, 0, 0}, kInfinity), 20);
}

TEST(SurfaceDistance, ThreadsDoNotChangeAnswers) {
    const Mesh mesh = strewn_mesh(60000, 1, 18);
    std::vector<double> answers[2];
    for (const int threads : {1, 16}) {
        core::set_thread_count(threads);
        const SurfaceDistance surface(mesh);
        Randoms random(19);
        for (int i = 0; i < 3000; ++i)
            answers[threads > 1].push_back(surface.distance(random.point(2), kInfinity));
    }
    core::set_thread_count(0);
    EXPECT_EQ(answers[0], answers[1]);
    for (int i = 0; i < 3; ++i) EXPECT_LT(answers[0][size_t(i)], 4);
}

}  // namespace
