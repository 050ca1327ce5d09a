#include "geom/sphere.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace {

std::vector<glm::vec3> random_points(float scale, glm::vec3 offset, int count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> coordinate(-1, 1);
    std::vector<glm::vec3> points;
    for (int i = 0; i < count; ++i)
        points.push_back(offset +
                         scale * glm::vec3(coordinate(random), 3 * coordinate(random), coordinate(random)));
    return points;
}

TEST(SphereAround, HoldsEveryPointAtAnyScale) {
    for (const float scale : {1e-38f, 1e-30f, 1e-6f, 1.0f, 1e30f, 1e38f})
        for (const float offset : {0.0f, 1.0f, 1e5f}) {
            const auto points =
                random_points(scale, glm::vec3(scale * offset < 1e38f ? scale * offset : 0), 500);
            const geom::Sphere sphere = geom::sphere_around(points);
            for (const glm::vec3& p : points)
                ASSERT_LE(glm::length((glm::dvec3(p) - sphere.centre) / double(scale)), sphere.radius / scale)
                    << "scale " << scale << ", offset " << offset;
        }
}

TEST(SphereAround, IsAtMostTwiceTheSmallest) {
    // The points of a unit sphere: the smallest sphere has radius 1.
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (int round = 0; round < 100; ++round) {
        std::vector<glm::vec3> points;
        for (int i = 0; i < 4; ++i)
            points.push_back(glm::normalize(glm::vec3(normal(random), normal(random), normal(random))));
        EXPECT_LE(geom::sphere_around(points).radius, 2.0f);
    }
}

TEST(SphereAround, OfOnePointIsThatPoint) {
    const std::vector<glm::vec3> points(3, glm::vec3(0.1f, -2e10f, 3e-20f));
    const geom::Sphere sphere = geom::sphere_around(points);
    EXPECT_EQ(sphere.centre, glm::dvec3(points[0]));
    EXPECT_EQ(sphere.radius, 0);
}

TEST(SphereAround, OfTrianglesLeavesOutTheVerticesTheyDoNotUse) {
    const std::vector<glm::vec3> points{{0, 0, 0}, {1e30f, 0, 0}, {2, 0, 0}, {0, 2, 0}};
    const std::vector<glm::u32vec3> triangles{{0, 2, 3}};
    const geom::Sphere sphere = geom::sphere_around(points, triangles);
    EXPECT_EQ(sphere.centre, glm::dvec3(1, 1, 0));
    EXPECT_NEAR(sphere.radius, std::sqrt(2), 1e-12);
    EXPECT_EQ(geom::sphere_around(points, {}).radius, 0);
}

TEST(SphereAround, OfNothingIsAPointAtZero) {
    const geom::Sphere sphere = geom::sphere_around({});
    EXPECT_EQ(sphere.centre, glm::dvec3(0));
    EXPECT_EQ(sphere.radius, 0);
}

}  // namespace
