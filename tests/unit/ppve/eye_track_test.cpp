#include "ppve/client/eye_track.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace {

using namespace ppve;

geom::Camera orbit(double t) {
    return {{4 * std::sin(0.3 * t), 1, 4 * std::cos(0.3 * t)}, {0, 0, 0}, {0, 1, 0}, 40, t};
}

TEST(EyeTrack, GoesOnAsBefore) {
    EyeTrack track;
    for (int k = 0; k <= 20; ++k) track.add(0.05 * k, orbit(0.05 * k));
    EXPECT_NEAR(track.turning_rad_per_s(), 0.3, 1e-6);
    const geom::Camera ahead = track.at(1.3), there = orbit(1.3);
    // A tenth of what the eye moves meanwhile: its way is a circle.
    EXPECT_LT(glm::length(ahead.eye - there.eye), 0.1 * glm::length(orbit(1).eye - there.eye));
    EXPECT_GT(glm::dot(glm::normalize(ahead.target - ahead.eye), glm::normalize(there.target - there.eye)),
              std::cos(0.01));
}

TEST(EyeTrack, StopsWhereTheEyeStops) {
    EyeTrack track;
    for (int k = 0; k <= 20; ++k) track.add(0.05 * k, orbit(0.05 * k));
    track.add(1.05, orbit(1));
    EXPECT_EQ(track.at(2).eye, orbit(1).eye);
    EXPECT_NEAR(track.still_s(), 0.05, 1e-9);
    track.add(1.5, orbit(1));
    EXPECT_NEAR(track.still_s(), 0.5, 1e-9);
    track.add(1.6, orbit(1.6));
    EXPECT_EQ(track.still_s(), 0);
}

TEST(EyeTrack, AJumpThrowsTheEyeNowhere) {
    EyeTrack track;
    track.add(0, orbit(0));
    track.add(0.001, orbit(8));
    const geom::Camera ahead = track.at(10);
    EXPECT_TRUE(std::isfinite(ahead.eye.x));
    const glm::dvec3 now = glm::normalize(orbit(8).target - orbit(8).eye);
    EXPECT_GT(glm::dot(glm::normalize(ahead.target - ahead.eye), now), std::cos(0.53));
}

TEST(EyeTrack, OnePoseIsWhereItIs) {
    EyeTrack track;
    track.add(3, orbit(1));
    EXPECT_EQ(track.at(9).eye, orbit(1).eye);
    EXPECT_EQ(track.turning_rad_per_s(), 0);
}

TEST(FrustumFor, HoldsWhatBothEyesSee) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> number(-1, 1);
    const geom::Camera camera{{0, 0, 5}, {0.3, 0.2, 0}, {0, 1, 0}, 40};
    const geom::View middle = geom::make_view(camera, 640, 400);
    const geom::View eyes[] = {geom::moved_aside(middle, -0.1, 5), geom::moved_aside(middle, 0.1, 5)};
    const Frustum frustum = frustum_for(camera, field_of(camera, eyes), 320, 200, 0.05, 1'000'000);
    check(frustum, "test");
    for (int k = 0; k < 1000; ++k) {
        const geom::View& eye = eyes[k % 2];
        const double depth = 0.05 * std::exp(3 * (number(random) + 1));
        const glm::dvec2 px{320 + 319 * number(random), 200 + 199 * number(random)};
        const glm::dvec2 at = (px - eye.principal()) * (depth / eye.focal_px);
        const Projected p =
            project(frustum, eye.eye + eye.right * at.x + eye.down * at.y + eye.forward * depth);
        EXPECT_GE(p.x, 0);
        EXPECT_GE(p.y, 0);
        EXPECT_LE(p.x, frustum.view.width);
        EXPECT_LE(p.y, frustum.view.height);
    }
}

TEST(FrustumFor, AMarginCostsPixelsNotDensity) {
    const geom::Camera camera{{0, 0, 5}, {0.3, 0.2, 0}, {0, 1, 0}, 40};
    const geom::View eye = geom::make_view(camera, 640, 400);
    const FieldOfView field = field_of(camera, {&eye, 1});
    const Frustum plain = frustum_for(camera, field, 320, 200, 0, 1'000'000);
    EXPECT_NEAR(plain.view.width, 320, 1);
    const Frustum wide = frustum_for(camera, field, 320, 200, 0.1, 1'000'000);
    EXPECT_GT(wide.view.width, 360);
    EXPECT_NEAR(wide.view.focal_px, plain.view.focal_px, 1e-9);
    const Frustum bounded = frustum_for(camera, field, 320, 200, 0.1, 10'000);
    EXPECT_LE(bounded.view.width * bounded.view.height, 10'000);
    // Of any shape, and bounded in any case.
    for (const double margin : {0.0, 3.0, 1e9})
        for (const int width : {1, 5, 16384}) {
            const Frustum any = frustum_for(camera, field, width, 7, margin, 20'000'000);
            EXPECT_NO_THROW(check(any, "test"));
        }
}

}  // namespace
