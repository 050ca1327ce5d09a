#include "scene/seen_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "test_meshes.h"
#include "views.h"

namespace {

using namespace scene_test;
using namespace splat_test;
using splat::LargestErrors;

constexpr double kUnit = 10;  // world units

// 64 x 64 pixels that look along z from the origin, of a wall at a depth of 10.
struct Wall {
    geom::View view;
    render::Frame frame;
    splat::CutCounts counts;

    Wall() {
        view.width = view.height = 64, view.focal_px = 64;
        frame.resize(64, 64);
        std::fill(frame.depth.begin(), frame.depth.end(), 10.0f);
    }
    // A splat as wide as 6.4 pixels at the wall's depth.
    void add(float x, float depth, float error_px) {
        counts.largest.add({{x, 0, depth}, 0.05f, error_px});
        counts.error_bound_px = std::max(counts.error_bound_px, double(error_px));
    }
    double seen() const { return scene::seen_error_px(counts, kUnit, view, frame); }
};

TEST(SeenError, IsThatOfTheLargestSplatThatIsNotHidden) {
    Wall wall;
    wall.add(0, 2, 7), wall.add(0, 1, 3), wall.add(0, 0.9f, 2);
    EXPECT_EQ(wall.seen(), 3);
}

TEST(SeenError, HasAllThatReachesThroughTheWall) {
    for (const float depth : {1.06f, 1.04f}) {
        Wall wall;
        wall.add(0, depth, 7), wall.add(0, 1, 3);
        EXPECT_EQ(wall.seen(), depth > 1.05f ? 3 : 7);
    }
}

TEST(SeenError, HasWhatASinglePixelLetsThrough) {
    Wall wall;
    wall.add(0, 2, 7);
    EXPECT_EQ(wall.seen(), 0);
    wall.frame.depth[32 * 64 + 31] = std::numeric_limits<float>::infinity();
    EXPECT_EQ(wall.seen(), 7);
    wall.frame.depth[32 * 64 + 31] = 20;
    EXPECT_EQ(wall.seen(), 7);
}

TEST(SeenError, LeavesOutWhatIsBesideThePicture) {
    for (const float x : {-3.0f, 3.0f, -1e20f, 1e20f}) {
        Wall wall;
        wall.add(x, 2, 7), wall.add(0, 1, 3);
        // Splats too wide to be looked for count as seen.
        EXPECT_EQ(wall.seen(), std::abs(x) < 1e10f ? 3 : 7) << x;
    }
}

TEST(SeenError, IsInfiniteWithTheEyeInsideASplat) {
    Wall wall;
    wall.add(0, 0.01f, std::numeric_limits<float>::infinity());
    EXPECT_EQ(wall.seen(), std::numeric_limits<double>::infinity());
}

TEST(SeenError, OfOtherSplatsIsNeverLeftOut) {
    Wall wall;
    wall.add(0, 2, 7);
    wall.counts.other_error_px = 4;
    EXPECT_EQ(wall.seen(), 4);
}

TEST(SeenError, OfSplatsThatWereNotKeptIsThatOfTheLeast) {
    Wall wall;
    for (size_t k = 0; k < LargestErrors::kMost; ++k) {
        EXPECT_EQ(wall.seen(), 0);
        wall.add(0, 2, 7 + float(k));
    }
    EXPECT_EQ(wall.seen(), 7);
}

TEST(LargestErrors, AreTheSameInAnyOrderAndInParts) {
    std::vector<float> errors(1000);
    for (size_t k = 0; k < errors.size(); ++k) errors[k] = float(k * 37 % 1000);
    LargestErrors all(2), first(2);
    for (const float error : errors) all.add({glm::vec3(0), 1, error});
    for (size_t k = 0; k < 500; ++k) first.add({glm::vec3(0), 1, errors[k]});
    LargestErrors rest(first.least_px());
    for (size_t k = 500; k < errors.size(); ++k) rest.add({glm::vec3(0), 1, errors[k]});
    first.add(rest);
    const auto sorted = [](const LargestErrors& largest) {
        std::vector<float> kept;
        for (const LargestErrors::Splat& splat : largest.splats()) kept.push_back(splat.error_px);
        std::sort(kept.begin(), kept.end());
        return kept;
    };
    EXPECT_EQ(sorted(all).size(), LargestErrors::kMost);
    EXPECT_EQ(sorted(all).back(), 999);
    EXPECT_EQ(sorted(all).front(), 1000 - float(LargestErrors::kMost));
    EXPECT_EQ(sorted(all), sorted(first));
}

TEST(LargestErrors, AreBeyondTheThreshold) {
    LargestErrors largest(2);
    largest.add({glm::vec3(0), 1, 2}), largest.add({glm::vec3(0), 1, 2.5f});
    ASSERT_EQ(largest.splats().size(), 1u);
    EXPECT_EQ(largest.splats()[0].error_px, 2.5f);
}

// A wall before a crinkled model: its bound is no matter any more.
TEST(SeenError, OfAModelBehindAnotherIsNotTheFramesBound) {
    const splat::Model ball = build_model(icosphere(6)), rough = build_model(soup(8));
    const geom::View view = fitted_view(ball);
    const glm::dvec3 away = 3.0 * ball.header().scale * view.forward;
    const scene::PlacedModel before{&ball}, behind{&rough, {.scale = 0.5, .translation = away}};
    for (const scene::Occlusion occlusion : {scene::Occlusion::off, scene::Occlusion::on}) {
        scene::DrawOptions options;
        options.occlusion = occlusion;
        const double alone = draw({before}, view, options).report.counts.error_bound_px;
        EXPECT_GT(draw({behind}, view, options).report.counts.error_bound_px, 1.5 * alone);
        EXPECT_EQ(draw({before, behind}, view, options).report.counts.error_bound_px, alone);
    }
}

}  // namespace
