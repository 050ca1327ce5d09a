#include "geom/framing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/error.h"

namespace {

using geom::Camera;
using geom::Sphere;

constexpr int kHeight = 1000;

// Of the spheres' outlines in the picture, in halves of its width and height: 1 touches an edge.
struct Reach {
    double left = -1e300, right = -1e300, top = -1e300, bottom = -1e300;
    double largest() const { return std::max({left, right, top, bottom}); }
};

// Tangent of the angle between the axis and the plane through the eye that touches a sphere on one side.
double tangent_beside(double across, double depth, double radius) {
    return std::tan(std::atan2(across, depth) + std::asin(radius / std::hypot(across, depth)));
}

Reach reach_of(const std::vector<Sphere>& spheres, const Camera& camera, double aspect) {
    const geom::View view = geom::make_view(camera, 1, 1);
    const double vertical = std::tan(0.5 * camera.fovy_deg * std::acos(-1.0) / 180);
    Reach reach;
    for (const Sphere& s : spheres) {
        const glm::dvec3 p = view.view_from_world(s.centre);
        reach.right = std::max(reach.right, tangent_beside(p.x, p.z, s.radius) / (vertical * aspect));
        reach.left = std::max(reach.left, tangent_beside(-p.x, p.z, s.radius) / (vertical * aspect));
        reach.bottom = std::max(reach.bottom, tangent_beside(p.y, p.z, s.radius) / vertical);
        reach.top = std::max(reach.top, tangent_beside(-p.y, p.z, s.radius) / vertical);
    }
    return reach;
}

std::vector<Sphere> scatter(std::mt19937& random, int count, double size) {
    std::uniform_real_distribution<double> place(-size, size), radius(0, 0.3 * size);
    std::vector<Sphere> spheres;
    for (int i = 0; i < count; ++i)
        spheres.push_back({{place(random), 0.4 * place(random), place(random)}, radius(random)});
    return spheres;
}

Camera random_camera(std::mt19937& random, double size) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> fovy(1, 100);
    Camera camera;
    camera.target = {0.1 * size, 0, 0};
    camera.eye = camera.target + size * glm::dvec3(normal(random), normal(random), normal(random));
    camera.fovy_deg = fovy(random);
    return camera;
}

TEST(Framing, FillsThePictureAsFarAsTheMarginSays) {
    std::mt19937 random(1);
    for (int i = 0; i < 300; ++i) {
        const double size = std::pow(10, i % 41 - 20), aspect = 0.3 + 0.01 * i, margin = 1 + 0.001 * i;
        const std::vector<Sphere> spheres = scatter(random, 1 + i % 7, size);
        const Camera camera = geom::framed(random_camera(random, size), spheres, aspect, margin);
        const Reach reach = reach_of(spheres, camera, aspect);
        // The tightest pair of edges is reached on both sides.
        EXPECT_NEAR(reach.largest() * margin, 1, 1e-9) << i;
        EXPECT_TRUE(std::abs(reach.left - reach.right) < 1e-9 || std::abs(reach.top - reach.bottom) < 1e-9)
            << i;
    }
}

TEST(Framing, LooksTheSameWay) {
    std::mt19937 random(2);
    for (int i = 0; i < 100; ++i) {
        const Camera before = random_camera(random, 1);
        const Camera after = geom::framed(before, scatter(random, 5, 1), 1.5, 1.05);
        const geom::View a = geom::make_view(before, 1, 1), b = geom::make_view(after, 1, 1);
        EXPECT_LT(glm::length(a.forward - b.forward) + glm::length(a.right - b.right), 1e-13) << i;
        EXPECT_EQ(before.fovy_deg, after.fovy_deg);
    }
}

TEST(Framing, KeepsItsDigitsFarFromTheOrigin) {
    const glm::dvec3 far(6e5, 5e6, 120);
    const std::vector<Sphere> here{{{0, 0, 0}, 0.5}, {{2, 0, 0}, 0.5}},
        there{{far, 0.5}, {far + glm::dvec3(2, 0, 0), 0.5}};
    const Camera a = geom::framed({{0, 0, 9}, {0, 0, 0}}, here, 2, 1.05);
    const Camera b = geom::framed({far + glm::dvec3(0, 0, 9), far}, there, 2, 1.05);
    EXPECT_LT(glm::length(b.eye - far - a.eye), 1e-8);
    EXPECT_LT(glm::length(b.target - far - a.target), 1e-8);
}

TEST(Framing, RefusesWhatHasNoExtent) {
    EXPECT_THROW(geom::framed({}, std::vector<Sphere>{{{1, 2, 3}, 0}}, 1, 1.05), core::Error);
}

}  // namespace
