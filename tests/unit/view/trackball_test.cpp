#include "view/trackball.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "cameras.h"
#include "view/camera_moves.h"

namespace {

constexpr int kWidth = 640, kHeight = 480;

TEST(Trackball, WhatWasUnderTheMouseComesUnderItAgain) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> x(200, 440), y(120, 360);
    for (int i = 0; i < 200; ++i) {
        const geom::Camera before = some_camera(random, 3);
        const glm::dvec2 from(x(random), y(random)), to(x(random), y(random));
        const view::Turn turn = view::turn_between(from, to, kWidth, kHeight);
        const geom::Camera after = view::turned(before, turn.axis, turn.angle);
        const geom::View was = geom::make_view(before, kWidth, kHeight),
                         is = geom::make_view(after, kWidth, kHeight);
        const glm::dvec3 a = view::on_ball(from, kWidth, kHeight), b = view::on_ball(to, kWidth, kHeight);
        const glm::dvec3 in_world = a.x * was.right + a.y * was.down + a.z * was.forward;
        EXPECT_NEAR(glm::dot(in_world, is.right), b.x, 1e-12);
        EXPECT_NEAR(glm::dot(in_world, is.down), b.y, 1e-12);
        EXPECT_NEAR(glm::dot(in_world, is.forward), b.z, 1e-12);
    }
}

TEST(Trackball, AThousandTurnsKeepTheDistanceAndComeBack) {
    std::mt19937_64 random(2);
    const geom::Camera before = some_camera(random, 1);
    geom::Camera camera = before;
    for (int i = 0; i < 1000; ++i) camera = view::turned(camera, {0, 1, 0}, 2 * std::numbers::pi / 1000);
    EXPECT_LT(glm::length(camera.eye - before.eye), 1e-11);
    EXPECT_NEAR(glm::length(camera.eye - camera.target), glm::length(before.eye - before.target), 1e-12);
}

TEST(Trackball, IsSmoothWhereTheBallEnds) {
    const double edge = 0.5 * kWidth + 0.5 * kHeight * std::sqrt(0.5);
    const glm::dvec3 inside = view::on_ball({edge - 1e-6, 240}, kWidth, kHeight),
                     outside = view::on_ball({edge + 1e-6, 240}, kWidth, kHeight);
    EXPECT_LT(glm::length(inside - outside), 1e-7);
    EXPECT_EQ(view::turn_between({5, 5}, {5, 5}, kWidth, kHeight).angle, 0);
}

view::Spin let_go_at(double turn_rad, double step_s) {
    view::Spin spin;
    spin.hold(0);
    double time_s = 0;
    for (int i = 0; i < 40; ++i) spin.drag({{0, 1, 0}, turn_rad}, time_s += step_s);
    spin.let_go(time_s);
    return spin;
}

TEST(Spin, GoesOnAsFastAsTheHandAndSlowsToRest) {
    view::Spin spin = let_go_at(0.02, 0.01);  // 2 rad/s
    EXPECT_TRUE(spin.is_spinning());
    EXPECT_NEAR(spin.step(0.41).angle, 0.02, 0.001);
    for (double t = 0.42; t < 10; t += 0.01) spin.step(t);
    EXPECT_FALSE(spin.is_spinning());
    EXPECT_EQ(spin.step(11).angle, 0);
}

TEST(Spin, TurnsAsFarHoweverOftenItIsAsked) {
    view::Spin often = let_go_at(0.02, 0.01), once = let_go_at(0.02, 0.01);
    double sum = 0;
    for (int i = 1; i <= 100; ++i) sum += often.step(0.4 + 0.005 * i).angle;
    EXPECT_NEAR(sum, once.step(0.9).angle, 1e-12);
}

TEST(Spin, RestsWhereTheHandHeldStill) {
    view::Spin spin;
    spin.hold(0);
    spin.drag({{0, 1, 0}, 0.1}, 0.01);
    spin.let_go(0.5);
    EXPECT_FALSE(spin.is_spinning());
}

}  // namespace
