#include "view/navigator.h"

#include <gtest/gtest.h>

#include "cameras.h"
#include "view/camera_moves.h"

namespace {

bool is_same(const geom::Camera& a, const geom::Camera& b) {
    return geom::format_camera(a) == geom::format_camera(b);
}

view::Navigator some_navigator() {
    std::mt19937_64 random(7);
    view::Navigator navigator(some_camera(random, 2), {{0, 0, 0}, 1});
    navigator.resize(640, 480);
    return navigator;
}

TEST(Navigator, HasItsHomeToTheBitUntilItIsMoved) {
    std::mt19937_64 random(7);
    const geom::Camera home = some_camera(random, 2);
    view::Navigator navigator = some_navigator();
    navigator.step(1);
    EXPECT_TRUE(is_same(navigator.camera(), home));
    EXPECT_FALSE(navigator.is_moving(1));
    navigator.turn(30, 10, 2);
    EXPECT_TRUE(navigator.is_moving(2));
    EXPECT_FALSE(is_same(navigator.camera(), home));
    navigator.go_home(3);
    EXPECT_TRUE(is_same(navigator.camera(), home));
}

TEST(Navigator, ThePanThatIsDraggedStaysUnderTheMouse) {
    view::Navigator navigator = some_navigator();
    const double depth = 1.25;
    const glm::dvec3 point = view::point_at(geom::make_view(navigator.camera(), 640, 480), 100, 200, depth);
    navigator.press(view::Drag::pan, {100, 200}, depth, 0);
    navigator.move_to({150, 210}, 0.1);
    navigator.move_to({300, 33}, 0.2);
    navigator.release(0.3);
    const glm::dvec2 px = seen_at(geom::make_view(navigator.camera(), 640, 480), point);
    EXPECT_NEAR(px.x, 300, 1e-9);
    EXPECT_NEAR(px.y, 33, 1e-9);
    EXPECT_FALSE(navigator.is_spinning());
}

TEST(Navigator, SpinsOnlyWhereItIsLetGoInMotionAndStopsAtAClick) {
    view::Navigator navigator = some_navigator();
    const auto turn = [&](double until_s) {
        navigator.press(view::Drag::turn, {300, 240}, {}, 0);
        for (int i = 1; i <= 10; ++i) navigator.move_to({300 + 6 * i, 240}, 0.02 * i);
        navigator.release(until_s);
    };
    turn(0.5);
    EXPECT_FALSE(navigator.is_spinning());
    turn(0.21);
    EXPECT_TRUE(navigator.is_spinning());
    const geom::Camera before = navigator.camera();
    navigator.step(0.3);
    EXPECT_FALSE(is_same(navigator.camera(), before));
    navigator.press(view::Drag::turn, {300, 240}, {}, 0.4);
    EXPECT_FALSE(navigator.is_spinning());
}

TEST(Navigator, GoesToAViewThatWasSavedAndToNoOther) {
    view::Navigator navigator = some_navigator();
    EXPECT_FALSE(navigator.go_to_view(3, 0));
    navigator.turn(50, 0, 1);
    const geom::Camera saved = navigator.camera();
    navigator.save_view(3);
    navigator.zoom({10, 10}, 2.0, 3, 2);
    EXPECT_TRUE(navigator.go_to_view(3, 3));
    EXPECT_TRUE(is_same(navigator.camera(), saved));
}

TEST(Navigator, LightComesFromWhereTheMouseIsOnTheBall) {
    view::Navigator navigator = some_navigator();
    navigator.press(view::Drag::light, {320, 240}, {}, 0);
    const geom::View view = geom::make_view(navigator.camera(), 640, 480);
    ASSERT_TRUE(navigator.key_light().has_value());
    EXPECT_NEAR(glm::dot(*navigator.key_light(), view.forward), -1, 1e-12);
    navigator.move_to({500, 240}, 0.1);
    EXPECT_GT(glm::dot(*navigator.key_light(), view.right), 0.5);
}

TEST(Navigator, AimsAtWhatIsSeenOnly) {
    view::Navigator navigator = some_navigator();
    EXPECT_FALSE(navigator.aim({20, 30}, {}, 0));
    const glm::dvec3 eye = navigator.camera().eye;
    const glm::dvec3 point = view::point_at(geom::make_view(navigator.camera(), 640, 480), 20, 30, 1.5);
    EXPECT_TRUE(navigator.aim({20, 30}, 1.5, 0));
    EXPECT_EQ(navigator.camera().eye, eye);
    EXPECT_LT(glm::length(navigator.camera().target - point), 1e-12);
}

}  // namespace
