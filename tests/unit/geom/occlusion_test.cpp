// What the map hides is hidden, and as near as it says; pictures drawn with it are compared in
// tests/unit/scene/occlusion_test.cpp.
#include "geom/occlusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace {

using geom::OcclusionMap;
using Sight = OcclusionMap::Sight;

constexpr int kBlock = OcclusionMap::kBlock;

geom::View view_of(int width, int height) {
    geom::View view;
    view.width = width, view.height = height;
    view.focal_px = 300;
    return view;
}

double uniform(std::mt19937_64& random, double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
}

glm::dvec3 within_unit_ball(std::mt19937_64& random) {
    for (;;) {
        const glm::dvec3 p(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
        if (glm::dot(p, p) <= 1) return p;
    }
}

// A square piece of a plane, covered by discs that overlap.
struct Wall {
    static constexpr double kSpacing = 0.5, kDisc = 0.5;
    glm::dvec3 middle, normal, across, along;
    double half_side;

    Wall(const glm::dvec3& at, const glm::dvec3& facing, double half)
        : middle(at),
          normal(glm::normalize(facing)),
          across(glm::normalize(glm::cross(normal, glm::dvec3(0, 1, 0)))),
          along(glm::cross(normal, across)),
          half_side(half) {}

    std::vector<OcclusionMap::Surface> discs() const {
        std::vector<OcclusionMap::Surface> discs;
        const int n = int(half_side / kSpacing);
        for (int i = -n; i <= n; ++i)
            for (int j = -n; j <= n; ++j)
                discs.push_back({glm::vec3(middle + kSpacing * (double(i) * across + double(j) * along)),
                                 float(kDisc), glm::vec3(normal), 0.01f});
        return discs;
    }
    // Whether some of it is between the eye and the point.
    bool hides(const glm::dvec3& p) const {
        const double t = glm::dot(normal, middle) / glm::dot(normal, p);
        const glm::dvec3 off = t * p - middle;
        const double reach = half_side + kDisc;
        return t > 0 && t < 1 && std::abs(glm::dot(off, across)) <= reach &&
               std::abs(glm::dot(off, along)) <= reach;
    }
};

struct Looked {
    OcclusionMap::Spheres spheres;
    Sight sights[OcclusionMap::Spheres::kCapacity];

    glm::dvec3 centre(size_t i) const { return {spheres.x[i], spheres.y[i], spheres.z[i]}; }
};

OcclusionMap::Spheres random_spheres(std::mt19937_64& random) {
    OcclusionMap::Spheres spheres;
    while (spheres.count < OcclusionMap::Spheres::kCapacity) {
        const double z = uniform(random, 1, 40);
        spheres.add(glm::vec3(z * uniform(random, -0.6, 0.6), z * uniform(random, -0.5, 0.5), z),
                    float(uniform(random, 0.05, 2)));
    }
    return spheres;
}

glm::dvec2 projected(const geom::View& view, const glm::dvec3& p) {
    return view.principal() + view.focal_px / p.z * glm::dvec2(p);
}

// Of the picture; negative where it is not in the raster.
glm::ivec2 pixel_of(const geom::View& view, const glm::dvec3& p) {
    const glm::ivec2 pixel(glm::floor(projected(view, p)));
    const bool is_in = pixel.x >= view.margins.left && pixel.x < view.margins.left + view.width &&
                       pixel.y >= view.margins.top && pixel.y < view.margins.top + view.height;
    return is_in ? pixel : glm::ivec2(-1);
}

// Whether the pixel is so many from the raster's sides.
bool is_within(const geom::View& view, const glm::ivec2& pixel, int border) {
    const glm::ivec2 at = pixel - glm::ivec2(view.margins.left, view.margins.top);
    return std::min(at.x, at.y) >= border && at.x < view.width - border && at.y < view.height - border;
}

// What is hidden is behind the wall wherever it would be seen, and the limit holds for splats in it.
void expect_hidden_is_behind(OcclusionMap& map, const geom::View& view, const Wall& wall,
                             const Looked& looked, std::mt19937_64& random) {
    for (size_t i = 0; i < looked.spheres.count; ++i) {
        if (looked.sights[i] != Sight::hidden) continue;
        const double radius = looked.spheres.radius[i];
        for (int n = 0; n < 50; ++n) {
            // The largest splat about a point that is in the sphere, and its fragment that is nearest to the
            // eye.
            const glm::dvec3 off = n == 0 ? glm::dvec3(0) : within_unit_ball(random);
            const glm::dvec3 centre = looked.centre(i) + radius * off;
            const double splat = radius * (1 - glm::length(off));
            const glm::dvec3 p = centre - splat * glm::normalize(centre);
            const glm::ivec2 pixel = pixel_of(view, p);
            if (pixel.x < 0) continue;
            // At the raster's sides there are no blocks beyond whose middles are looked at.
            const bool is_inner = is_within(view, pixel, kBlock / 2);
            ASSERT_TRUE(!is_inner || wall.hides(p)) << p.x << ' ' << p.y << ' ' << p.z;
            const double push = splat / (centre.z * (centre.z + splat));
            ASSERT_LE(1 / p.z + push, map.limit(pixel.x, pixel.y));
        }
    }
}

TEST(OcclusionMap, HidesWhatIsBehindTheSurfaceAloneAndSaysHowNearItComes) {
    std::mt19937_64 random(1);
    OcclusionMap map;
    size_t hidden = 0;
    for (int round = 0; round < 60; ++round) {
        geom::View view = view_of(int(uniform(random, 40, 400)), int(uniform(random, 40, 300)));
        if (round % 3 == 0)
            view = geom::part_of(view, view.width / 5, view.height / 7, view.width / 2, view.height / 2);
        const Wall wall({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, 6, 12)},
                        {uniform(random, -0.7, 0.7), uniform(random, -0.7, 0.7), -1}, uniform(random, 2, 8));
        map.begin(view, 1);
        map.add_surfaces(wall.discs());
        map.build();
        Looked looked{random_spheres(random), {}};
        map.look(looked.spheres, looked.sights);
        hidden += size_t(std::count(looked.sights, looked.sights + looked.spheres.count, Sight::hidden));
        expect_hidden_is_behind(map, view, wall, looked, random);
    }
    EXPECT_GT(hidden, 500u);
}

TEST(OcclusionMap, HidesWhatIsFarBehindAWallThatFillsThePicture) {
    const geom::View view = view_of(320, 240);
    const Wall wall({0, 0, 6}, {0, 0, -1}, 10);
    OcclusionMap map;
    OcclusionMap::Spheres spheres;
    spheres.add({0, 0, 20}, 1);     // behind
    spheres.add({3, -2, 30}, 2);    // behind, and wider than a block
    spheres.add({0, 0, 3}, 0.3f);   // before it
    spheres.add({0, 0, 30}, 0.1f);  // behind, and too small to look at
    spheres.add({0, 0, 6.2f}, 1);   // on both sides
    spheres.add({0, 0, 20}, 6);     // nearer than four of its radii
    Sight sights[OcclusionMap::Spheres::kCapacity];
    const auto look = [&] {
        map.build();
        map.look(spheres, sights);
        return std::vector<Sight>(sights, sights + spheres.count);
    };
    map.begin(view, 1);
    EXPECT_EQ(look(), (std::vector{Sight::clear, Sight::clear, Sight::clear, Sight::clear, Sight::clear,
                                   Sight::partly}));
    EXPECT_FALSE(map.has_hidden());
    EXPECT_EQ(map.limit(160, 120), 0);
    map.begin(view, 1);
    map.add_surfaces(wall.discs());
    EXPECT_EQ(look(), (std::vector{Sight::hidden, Sight::hidden, Sight::clear, Sight::clear, Sight::clear,
                                   Sight::partly}));
    EXPECT_TRUE(map.has_hidden());
    EXPECT_GE(map.limit(160, 120), 1.0f / 19);
}

TEST(OcclusionMap, TakesNoSurfaceBeforeTheNearPlane) {
    geom::View view = view_of(320, 240);
    view.near = 16.0;  // world units: 8 of the splats
    const Wall wall({0, 0, 6}, {0, 0, -1}, 10);
    OcclusionMap map;
    map.begin(view, 2);
    map.add_surfaces(wall.discs());
    map.build();
    OcclusionMap::Spheres spheres;
    spheres.add({0, 0, 20}, 1);
    Sight sights[OcclusionMap::Spheres::kCapacity];
    map.look(spheres, sights);
    EXPECT_EQ(sights[0], Sight::clear);
}

// The second time all of what reaches into blocks that were not proved is drawn, and nothing that is two
// blocks off.
TEST(OcclusionMap, PassesTheSecondTimeWhatReachesIntoUnprovenBlocks) {
    std::mt19937_64 random(2);
    OcclusionMap map;
    const geom::View view = view_of(400, 300);
    size_t passed = 0, left_out = 0;
    for (int round = 0; round < 40; ++round) {
        map.begin(view, 1);
        map.build();
        const glm::ivec2 marked(int(random() % 400), int(random() % 300));
        EXPECT_FALSE(map.has_unproven());
        map.mark_unproven(marked.x, marked.y);
        EXPECT_TRUE(map.has_unproven() && map.is_unproven(marked.x, marked.y));
        map.begin_repeat();
        EXPECT_TRUE(map.is_repeated());
        Looked looked{random_spheres(random), {}};
        map.look(looked.spheres, looked.sights);
        for (size_t i = 0; i < looked.spheres.count; ++i) {
            const double radius = looked.spheres.radius[i];
            const bool is_passed = looked.sights[i] != Sight::hidden;
            (is_passed ? passed : left_out) += 1;
            double nearest_px = radius * 4 >= looked.spheres.z[i] ? 0 : INFINITY;
            for (int n = 0; n < 200; ++n) {
                const glm::dvec3 p = looked.centre(i) + radius * within_unit_ball(random);
                const glm::ivec2 pixel = pixel_of(view, p);
                ASSERT_TRUE(is_passed || pixel.x < 0 || pixel / kBlock != marked / kBlock);
                nearest_px = std::min(nearest_px, glm::distance(projected(view, p), glm::dvec2(marked)));
            }
            ASSERT_TRUE(!is_passed || nearest_px < 4 * kBlock);
        }
    }
    EXPECT_GT(passed, 100u);
    EXPECT_GT(left_out, 1000u);
}

}  // namespace
