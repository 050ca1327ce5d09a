#include "view/camera_moves.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cameras.h"

namespace {

TEST(CameraMoves, ThePointThatIsApproachedKeepsItsPlaceInThePicture) {
    std::mt19937_64 random(1);
    for (const double size : {1e-30, 1.0, 1e30}) {
        const geom::Camera before = some_camera(random, size);
        const geom::View was = geom::make_view(before, 640, 480);
        const glm::dvec3 point = view::point_at(was, 123, 456, 2 * size);
        const geom::Camera after = view::approached(before, point, 0.5, 0);
        const glm::dvec2 px = seen_at(geom::make_view(after, 640, 480), point);
        EXPECT_NEAR(px.x, 123, 1e-9) << size;
        EXPECT_NEAR(px.y, 456, 1e-9) << size;
        EXPECT_NEAR(glm::length(after.eye - point) / glm::length(before.eye - point), 0.5, 1e-12);
    }
}

TEST(CameraMoves, NoNumberOfStepsMakesACameraThatCannotBeDrawn) {
    std::mt19937_64 random(2);
    for (const double size : {1e-100, 1e-30, 1.0, 1e30, 1e100}) {
        for (const double factor : {0.5, 2.0}) {
            geom::Camera camera = some_camera(random, size);
            for (int i = 0; i < 2000; ++i) {
                camera = view::approached(camera, camera.target, factor, 0);
                camera = view::moved(camera, camera.target - camera.eye);
                camera = view::widened(camera, factor);
            }
            EXPECT_NO_THROW(geom::check(camera)) << size << " " << factor;
            EXPECT_GE(camera.fovy_deg, 1);
            EXPECT_LE(camera.fovy_deg, 150);
        }
    }
}

TEST(CameraMoves, ComesNoNearerThanIsAllowed) {
    geom::Camera camera;
    for (int i = 0; i < 100; ++i) camera = view::approached(camera, {0, 0, 0}, 0.8, 0.1);
    EXPECT_GE(glm::length(camera.eye), 0.1);
    EXPECT_LT(glm::length(camera.eye), 0.1 / 0.8);
}

TEST(CameraMoves, PointAtIsSeenThereAndAtThatDepth) {
    std::mt19937_64 random(3);
    const geom::View view = geom::make_view(some_camera(random, 5), 200, 100);
    const glm::dvec3 point = view::point_at(view, 17.5, 80.25, 3);
    EXPECT_NEAR(view.view_from_world(point).z, 3, 1e-12);
    EXPECT_NEAR(seen_at(view, point).x, 17.5, 1e-9);
    EXPECT_NEAR(seen_at(view, point).y, 80.25, 1e-9);
}

}  // namespace
