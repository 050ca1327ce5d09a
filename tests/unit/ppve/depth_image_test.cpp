#include "ppve/depth_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "scenes.h"

namespace {

using ppve::DepthCoding;
using ppve::Projection;

// The image of a depth error: how far the sample moves, seen from the side, in pixels of its own view.
double moved_px(const ppve::Frustum& f, double depth, double back) {
    return std::abs(back - depth) / ppve::footprint(f, 1, depth);
}

TEST(DepthCoding, MovesNoSampleByMoreThanItsBoundFromNear1e6thToFar1e9) {
    const ppve::Frustum f = ppve_test::looking_from({0, 0, 0}, {0, 0, 1}, 1280, 800);
    const DepthCoding coding = ppve::choose_coding(f, 0.01, 1e-6, 1e9);
    const double bound = ppve::bound_px(coding, f.view.focal_px);
    EXPECT_LE(bound, 0.01);
    std::mt19937_64 random(1);
    for (int n = 0; n < 200000; ++n) {
        const double depth = std::exp2(ppve_test::uniform(random, std::log2(1e-6), std::log2(1e9)));
        ASSERT_LE(moved_px(f, depth, coding.depth(coding.code(depth))), bound * (1 + 1e-9)) << depth;
    }
}

TEST(DepthCoding, IsMonotoneAndItsOwnInverse) {
    const ppve::Frustum f = ppve_test::looking_from({0, 0, 0}, {0, 0, 1}, 64, 64);
    for (const double bound : {10.0, 0.01, 0.0}) {
        const DepthCoding coding = ppve::choose_coding(f, bound, 0.5, 100);
        uint32_t last = std::numeric_limits<uint32_t>::max();
        for (double depth = 0.5; depth <= 100; depth *= 1.0001) {
            const uint32_t code = coding.code(depth);
            ASSERT_LE(code, last);
            ASSERT_EQ(coding.code(coding.depth(code)), code);
            last = code;
        }
        EXPECT_GE(last, 1u);
    }
}

TEST(DepthCoding, OrthographicStepsAreEvenAndMeetTheBound) {
    ppve::Frustum f = ppve_test::looking_from({0, 0, 0}, {0, 0, 1}, 640, 480);
    f.projection = Projection::orthographic, f.view.focal_px = 200;
    const DepthCoding coding = ppve::choose_coding(f, 0.01, -50, 1000);
    const double bound = ppve::bound_px(coding, f.view.focal_px);
    EXPECT_LE(bound, 0.01);
    std::mt19937_64 random(2);
    for (int n = 0; n < 100000; ++n) {
        const double depth = ppve_test::uniform(random, -50, 1000);
        ASSERT_LE(moved_px(f, depth, coding.depth(coding.code(depth))), bound * (1 + 1e-9));
    }
}

TEST(DepthCoding, GrowsWithTheFocalLengthUntilTheCodesAreTooFew) {
    // A field of view of a millionth of a degree: focal length 4.6e10 pixels; what is seen is 1 deep at 1e6.
    const ppve::Frustum f = ppve_test::looking_from({0, 0, 0}, {0, 0, 1}, 1280, 800, 1e-6);
    const DepthCoding coding = ppve::choose_coding(f, 0.01, 1e6, 1e6 + 1);
    EXPECT_LE(ppve::bound_px(coding, f.view.focal_px), 0.01);
    const double depth = 1e6 + 0.123456789;
    EXPECT_LE(moved_px(f, depth, coding.depth(coding.code(depth))), 0.01);
    // With all depths there are, the bound is what 32 bits can hold, and is said so.
    const DepthCoding coarse = ppve::choose_coding(f, 0.01, 1e-6, 1e9);
    EXPECT_GT(ppve::bound_px(coarse, f.view.focal_px), 0.01);
    EXPECT_EQ(coarse.code(coarse.depth(coarse.code(1.0))), coarse.code(1.0));
}

TEST(DepthCoding, WhatIsOutOfRangeHasTheNearestCode) {
    const ppve::Frustum f = ppve_test::looking_from({0, 0, 0}, {0, 0, 1}, 64, 64);
    const DepthCoding coding = ppve::choose_coding(f, 0.01, 1, 10);
    EXPECT_EQ(coding.code(1e300), 1u);
    EXPECT_GE(coding.code(0), coding.code(1));
    EXPECT_GE(coding.code(-5), coding.code(1));
}

TEST(DepthImage, PositionsProjectBackToTheCentresOfTheirPixels) {
    std::mt19937_64 random(3);
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
        ppve::Frustum f = ppve_test::looking_from({1, 2, 3}, {-4, 0.5, 7}, 320, 200);
        f.projection = projection;
        f.view.shift_px = {17, -5};
        f.view.right = -f.view.right;  // mirrored
        const DepthCoding coding = ppve::choose_coding(f, 0.01, 0.1, 50);
        for (int n = 0; n < 10000; ++n) {
            const int i = int(random() % 320), j = int(random() % 200);
            const uint32_t code = coding.code(ppve_test::uniform(random, 0.1, 50));
            const ppve::Projected at = ppve::project(f, ppve::position_of(f, coding, i, j, code));
            ASSERT_NEAR(at.x, i + 0.5, 1e-9);
            ASSERT_NEAR(at.y, j + 0.5, 1e-9);
            ASSERT_NEAR(at.depth, coding.depth(code), 1e-12 * 50);
        }
    }
}

TEST(DepthImage, NormalsComeBackWithinTheirBound) {
    std::mt19937_64 random(4);
    double worst = 0;
    for (int n = 0; n < 100000; ++n) {
        const glm::vec3 normal =
            glm::normalize(glm::vec3(ppve_test::uniform(random, -1, 1), ppve_test::uniform(random, -1, 1),
                                     ppve_test::uniform(random, -1, 1)));
        const glm::vec3 back = ppve::octahedral_normal(ppve::octahedral_code(normal));
        worst = std::max(worst, double(std::acos(std::min(1.0f, glm::dot(normal, back)))));
    }
    EXPECT_LE(worst, 0.017);
    EXPECT_EQ(ppve::octahedral_normal(ppve::octahedral_code(glm::vec3(0))), glm::vec3(0));
    EXPECT_EQ(ppve::octahedral_code({NAN, 0, 1}), ppve::kUnknownNormal);
}

TEST(Frustum, WhatCannotBeSampledIsRefused) {
    const ppve::Frustum good = ppve_test::looking_from({0, 0, 5}, {0, 0, 0}, 100, 100);
    EXPECT_NO_THROW(ppve::check(good, "request"));
    const auto refused = [&](const auto& spoil) {
        ppve::Frustum f = good;
        spoil(f.view);
        EXPECT_THROW(ppve::check(f, "request"), core::Error);
    };
    refused([](geom::View& v) { v.width = 0; });
    refused([](geom::View& v) { v.height = ppve::kMostSide + 1; });
    refused([](geom::View& v) { v.focal_px = NAN; });
    refused([](geom::View& v) { v.focal_px = 0; });
    refused([](geom::View& v) { v.eye.x = INFINITY; });
    refused([](geom::View& v) { v.eye.y = 1e101; });
    refused([](geom::View& v) { v.right *= 1.001; });
    refused([](geom::View& v) { v.down = v.right; });
    refused([](geom::View& v) { v.forward.z = NAN; });
    refused([](geom::View& v) { v.near = -1; });
    refused([](geom::View& v) { v.near = 2, v.far = 1; });
    refused([](geom::View& v) { v.shift_px.x = NAN; });
}

}  // namespace
