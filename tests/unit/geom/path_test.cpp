#include "geom/path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "core/error.h"

namespace {

using geom::Camera;
using geom::Shot;
using geom::Sphere;
using geom::View;

constexpr int kHeight = 720;

std::vector<Sphere> spheres() {
    return {{{0, 0, 0}, 1},           {{1, -2, 3}, 1e-30},     {{0, 0, 0}, 1e-140},
            {{3e139, 0, 0}, 1e140},   {{6e5, 5e6, 120}, 0.01}, {{1e12, 1e12, 1e12}, 1},
            {{1e14, -1e14, 1e14}, 1}, {{1, 2, 3}, 0},          {{0, 0, 0}, 0}};
}

View view_of(const Camera& camera, double aspect) {
    return geom::make_view(camera, int(std::lround(kHeight * aspect)), kHeight);
}

// How far the picture of the sphere reaches beyond the frame's nearest edge, as a fraction of the radius:
// the signed distance from the sphere to the frustum's side planes.
double beyond_frame(const Sphere& sphere, const Camera& camera, double aspect) {
    const View view = view_of(camera, aspect);
    const glm::dvec3 p = view.view_from_world(sphere.centre);
    double worst = -1e300;
    for (const double half_px : {view.width * 0.5, view.height * 0.5}) {
        const double across = half_px == view.width * 0.5 ? std::abs(p.x) : std::abs(p.y);
        // Plane through the eye and a frame's edge; its normal points outwards.
        const double tangent = half_px / view.focal_px, length = std::hypot(1, tangent);
        worst = std::max(worst, (across - p.z * tangent) / length + sphere.radius);
    }
    return worst / sphere.radius;
}

void expect_valid(const std::vector<Camera>& path, const std::string& what) {
    for (const Camera& camera : path) {
        const View view = view_of(camera, 16.0 / 9);  // throws where it is not finite
        for (const glm::dvec3& axis : {view.right, view.down, view.forward})
            ASSERT_NEAR(glm::length(axis), 1, 1e-15) << what;
        ASSERT_TRUE(std::isfinite(camera.time_s) && std::isfinite(view.focal_px)) << what;
    }
}

bool same_camera_but_time(Camera a, const Camera& b) {
    a.time_s = b.time_s;
    return geom::format_camera(a) == geom::format_camera(b);
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

TEST(Path, HoldsNoNanAtAnyScaleAndFieldOfView) {
    for (const Sphere& sphere : spheres())
        for (const double fovy : {0.001, 30.0, 179.0})
            for (const glm::dvec3 up : {glm::dvec3(0, 1, 0), glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0)}) {
                const Shot shot{.frames = 24, .fovy_deg = fovy, .up = up};
                const std::string what = core::text("radius %g, fovy %g", sphere.radius, fovy);
                expect_valid(geom::orbit(sphere, shot), "orbit, " + what);
                expect_valid(geom::dolly(sphere, shot), "dolly, " + what);
                expect_valid(geom::walk(sphere, shot), "walk, " + what);
                const auto keys = geom::orbit(sphere, {.frames = 5, .fovy_deg = fovy, .up = up});
                expect_valid(geom::spline(keys), "spline, " + what);
            }
}

TEST(Path, OfOneFrameIsItsFirst) {
    const Sphere sphere{{0, 0, 0}, 1};
    const Shot one{.frames = 1}, two{.frames = 2};
    EXPECT_TRUE(same_camera_but_time(geom::orbit(sphere, one).at(0), geom::orbit(sphere, two).at(0)));
    EXPECT_TRUE(same_camera_but_time(geom::dolly(sphere, one).at(0), geom::dolly(sphere, two).at(0)));
    EXPECT_TRUE(
        same_camera_but_time(geom::walk(sphere, one, {.laps = 1}).at(0), geom::walk(sphere, two).at(0)));
}

TEST(Path, TakesItsTimesFromFps) {
    const auto path = geom::orbit({{0, 0, 0}, 1}, {.frames = 50, .fps = 25});
    for (size_t i = 0; i < path.size(); ++i) EXPECT_EQ(path[i].time_s, double(i) / 25);
}

TEST(Path, RefusesBoundsThatAreNotFinite) {
    EXPECT_THROW(geom::orbit({{NAN, 0, 0}, 1}, {}), core::Error);
    EXPECT_THROW(geom::orbit({{0, 0, 0}, INFINITY}, {}), core::Error);
    EXPECT_THROW(geom::walk({{0, 0, 0}, 1e150}, {}), core::Error);
}

TEST(Orbit, KeepsTheWholeSphereInTheFrame) {
    for (const Sphere& sphere : spheres()) {
        if (sphere.radius < 1e-10 * glm::length(sphere.centre))
            continue;  // smaller than the rounding of the eye
        for (const double fovy : {0.001, 1.0, 30.0, 90.0, 179.0})
            for (const double aspect : {0.25, 1.0, 16.0 / 9, 8.0}) {
                const Shot shot{.frames = 30, .fovy_deg = fovy, .aspect = aspect};
                for (const Camera& camera : geom::orbit(sphere, shot, {.elevation_deg = 40}))
                    ASSERT_LE(beyond_frame(sphere, camera, aspect), 0)
                        << fovy << " degrees, aspect " << aspect;
            }
    }
}

TEST(Orbit, AtDistance1TouchesTheFrame) {
    const Sphere sphere{{5, 6, 7}, 2};
    for (const double fovy : {1.0, 30.0, 120.0})
        for (const double aspect : {0.5, 1.0, 2.0}) {
            const Shot shot{.frames = 7, .fovy_deg = fovy, .aspect = aspect};
            for (const Camera& camera : geom::orbit(sphere, shot, {.distance = 1}))
                EXPECT_NEAR(beyond_frame(sphere, camera, aspect), 0, 1e-12) << fovy << ", " << aspect;
        }
}

TEST(Orbit, ClosesWithoutADoubledFrame) {
    const auto path = geom::orbit({{0, 0, 0}, 1}, {.frames = 36});
    for (size_t i = 0; i < path.size(); ++i) {
        const Camera& next = path[(i + 1) % path.size()];
        const glm::dvec3 here(path[i].eye.x, 0, path[i].eye.z), there(next.eye.x, 0, next.eye.z);
        EXPECT_NEAR(angle_between(here, there), 2 * 3.14159265358979 / 36, 1e-12) << i;
    }
}

TEST(Orbit, StartsAtTheFrontAndGoesToTheRight) {
    const Sphere sphere{{0, 0, 0}, 1};
    const Shot y_up{.frames = 4}, z_up{.frames = 4, .up = {0, 0, 1}};
    const auto by_y = geom::orbit(sphere, y_up, {.elevation_deg = 0, .distance = 1});
    const auto by_z = geom::orbit(sphere, z_up, {.elevation_deg = 0, .distance = 1});
    const double d = geom::fit_distance(sphere, 30, 16.0 / 9);
    EXPECT_LT(glm::distance(by_y[0].eye, {0, 0, d}), 1e-12);
    EXPECT_LT(glm::distance(by_y[1].eye, {d, 0, 0}), 1e-12);
    EXPECT_LT(glm::distance(by_z[0].eye, {0, -d, 0}), 1e-12);
    EXPECT_LT(glm::distance(by_z[1].eye, {d, 0, 0}), 1e-12);
    EXPECT_EQ(by_y[0].up, glm::dvec3(0, 1, 0));
}

TEST(Orbit, KeepsUpAtARightAngleEvenAtThePoles) {
    for (const double elevation : {-90.0, -89.99999, 15.0, 90.0})
        for (const Camera& camera : geom::orbit({{0, 0, 0}, 1}, {.frames = 12}, {.elevation_deg = elevation}))
            EXPECT_NEAR(angle_between(camera.up, camera.target - camera.eye), 3.14159265358979 / 2, 1e-12);
}

TEST(Orbit, GoesBackwardsWithNegativeTurns) {
    const Sphere sphere{{0, 0, 0}, 1};
    const auto forward = geom::orbit(sphere, {.frames = 10});
    const auto backward = geom::orbit(sphere, {.frames = 10}, {.turns = -1});
    for (size_t i = 1; i < 10; ++i) EXPECT_LT(glm::distance(forward[i].eye, backward[10 - i].eye), 1e-12);
}

TEST(Dolly, ZoomsByTheSameFactorEachFrameAndComesBack) {
    const Sphere sphere{{10, 0, 0}, 3};
    const geom::Dolly options{.far_factor = 5, .near_factor = 0.05};
    const auto path = geom::dolly(sphere, {.frames = 40}, options);
    const auto distance = [&](size_t i) { return glm::distance(path[i % 40].eye, sphere.centre); };
    for (size_t i = 0; i < 40; ++i)
        EXPECT_NEAR(distance(i + 1) / distance(i), std::pow(0.01, i < 20 ? 1 / 20.0 : -1 / 20.0), 1e-12) << i;
}

TEST(Dolly, ReachesBothEndsWithAnyNumberOfFrames) {
    const Sphere sphere{{0, 0, 0}, 1};
    const double fit = geom::fit_distance(sphere, 30, 16.0 / 9);
    for (int frames = 2; frames < 12; ++frames) {
        double nearest = 1e300, farthest = 0;
        for (const Camera& camera :
             geom::dolly(sphere, {.frames = frames}, {.far_factor = 2, .near_factor = 0.5})) {
            nearest = std::min(nearest, glm::length(camera.eye));
            farthest = std::max(farthest, glm::length(camera.eye));
        }
        EXPECT_NEAR(nearest, 0.5 * fit, 1e-12) << frames;
        EXPECT_NEAR(farthest, 2 * fit, 1e-12) << frames;
    }
}

TEST(Dolly, StaysOutsideTheSphereUntilToldOtherwise) {
    const Sphere sphere{{0, 0, 0}, 1};
    for (const double fovy : {0.001, 30.0, 60.0, 120.0, 179.0}) {
        double nearest = 1e300;
        for (const Camera& camera : geom::dolly(sphere, {.fovy_deg = fovy}))
            nearest = std::min(nearest, glm::length(camera.eye));
        EXPECT_NEAR(nearest, 1.1, 1e-9) << fovy;
    }
}

TEST(Dolly, LooksAtItsTarget) {
    const glm::dvec3 target(0.5, 0.6, 0.7);
    for (const Camera& camera : geom::dolly({{0, 0, 0}, 1}, {.frames = 9}, {.target = target}))
        EXPECT_EQ(camera.target, target);
}

TEST(Dolly, RefusesToBeNearerFarAway) {
    EXPECT_THROW(geom::dolly({{0, 0, 0}, 1}, {}, {.far_factor = 1, .near_factor = 1}), core::Error);
}

TEST(Walk, RepeatsItsLapsBitForBit) {
    const auto path = geom::walk({{0.1, 0.2, 0.3}, 0.7}, {.frames = 150}, {.laps = 3});
    for (size_t i = 0; i < 100; ++i) EXPECT_TRUE(same_camera_but_time(path[i], path[i + 50])) << i;
}

TEST(Walk, GoesFromTopToBottomAndBackWithoutAJump) {
    const Sphere sphere{{0, 0, 0}, 1};
    const auto path = geom::walk(sphere, {.frames = 480});
    EXPECT_NEAR(path[0].target.y, 0.6, 1e-12);
    EXPECT_NEAR(path[120].target.y, -0.6, 1e-12);
    double longest = 0, total = 0;
    for (size_t i = 0; i < 240; ++i) {
        if (i < 120) {
            EXPECT_LT(path[i + 1].eye.y, path[i].eye.y) << i;
        }
        const double step = glm::distance(path[(i + 1) % 240].eye, path[i].eye);
        longest = std::max(longest, step);
        total += step;
    }
    EXPECT_LT(longest, 2 * total / 240);
}

TEST(Walk, StaysOutsideTheSphereUntilToldOtherwise) {
    for (const double fovy : {0.001, 30.0, 60.0, 120.0, 179.0})
        for (const Camera& camera : geom::walk({{0, 0, 0}, 1}, {.fovy_deg = fovy}))
            ASSERT_GT(glm::length(camera.eye), 1) << fovy;
}

TEST(Walk, RefusesLapsOfUnequalLength) {
    EXPECT_THROW(geom::walk({{0, 0, 0}, 1}, {.frames = 101}), core::Error);
}

std::vector<Camera> random_keys(size_t count, double scale, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    const auto point = [&] { return glm::dvec3(number(random), number(random), number(random)); };
    std::vector<Camera> keys;
    for (size_t i = 0; i < count; ++i)
        keys.push_back({.eye = scale * (glm::dvec3(5, 5, 5) + point()),
                        .target = scale * point(),
                        .up = glm::dvec3(0, 5, 0) + point(),
                        .fovy_deg = 60 + 50 * number(random),
                        .time_s = double(i * (i + 1)) / 2,
                        .near = scale * (2 + number(random))});
    return keys;
}

TEST(Spline, MeetsItsKeysBitForBit) {
    for (const double scale : {1e-140, 1e-30, 1.0, 1e30, 1e140}) {
        const auto keys = random_keys(6, scale, 1);
        const auto open = geom::spline(keys, {.frames = 51});
        const auto closed = geom::spline(keys, {.frames = 60, .closed = true});
        const auto timed = geom::spline(keys, {.timing = geom::Spline::Timing::keys, .fps = 10});
        ASSERT_EQ(open.size(), 51u);
        ASSERT_EQ(closed.size(), 60u);
        ASSERT_EQ(timed.size(), 151u);
        for (size_t k = 0; k < keys.size(); ++k) {
            EXPECT_TRUE(same_camera_but_time(open[10 * k], keys[k])) << scale << ", key " << k;
            EXPECT_TRUE(same_camera_but_time(closed[10 * k], keys[k])) << scale << ", key " << k;
            EXPECT_TRUE(same_camera_but_time(timed[size_t(10 * keys[k].time_s)], keys[k]))
                << scale << ", key " << k;
            EXPECT_EQ(timed[size_t(10 * keys[k].time_s)].time_s, keys[k].time_s);
        }
        expect_valid(open, "open");
        expect_valid(closed, "closed");
        expect_valid(timed, "timed");
    }
}

// The largest change of the step from frame to frame, against the largest step.
double roughness(const std::vector<Camera>& path, bool closed) {
    const size_t steps = path.size() - (closed ? 0 : 1);
    const auto step = [&](size_t i) { return path[(i + 1) % path.size()].eye - path[i % path.size()].eye; };
    double change = 0, longest = 0;
    for (size_t i = 0; i < steps; ++i) {
        longest = std::max(longest, glm::length(step(i)));
        if (closed || i + 1 < steps) change = std::max(change, glm::length(step(i + 1) - step(i)));
    }
    return change / longest;
}

TEST(Spline, HasNoCornersOrJumpsOfSpeed) {
    const auto keys = random_keys(7, 1, 2);
    // A smooth path's changes of step shrink with the step; those at a corner or a jump of speed do not.
    EXPECT_LT(roughness(geom::spline(keys, {.frames = 6001}), false), 0.02);
    EXPECT_LT(roughness(geom::spline(keys, {.frames = 7000, .closed = true}), true), 0.02);
    const auto timed = geom::spline(keys, {.timing = geom::Spline::Timing::keys, .fps = 1000});
    EXPECT_LT(roughness(timed, false), 0.02);
}

TEST(Spline, OfKeysOnALineStaysOnIt) {
    std::vector<Camera> keys(4);
    const double x[] = {0, 1, 100, 101};
    for (size_t i = 0; i < 4; ++i) keys[i] = {.eye = {x[i], 0, 5}, .target = {x[i], 0, 0}};
    double before = -1;
    for (const Camera& camera : geom::spline(keys, {.frames = 300})) {
        EXPECT_GT(camera.eye.x, before);  // neither loops nor overshoots
        EXPECT_EQ(camera.eye.y, 0);
        EXPECT_EQ(camera.fovy_deg, 30);  // what does not change does not change by a digit
        before = camera.eye.x;
    }
    EXPECT_EQ(before, 101);
}

TEST(Spline, RestsBetweenEqualKeys) {
    std::vector<Camera> keys = random_keys(4, 1, 3);
    keys[2] = keys[1];
    const auto path = geom::spline(keys, {.frames = 31});
    for (size_t i = 10; i <= 20; ++i) EXPECT_LT(glm::distance(path[i].eye, keys[1].eye), 1e-5);
    const std::vector<Camera> still(3, keys[0]);
    for (const Camera& camera : geom::spline(still)) EXPECT_LT(glm::distance(camera.eye, keys[0].eye), 1e-14);
}

TEST(Spline, KeepsTheFieldOfViewBetween0And180) {
    const double fovy[] = {0.001, 179, 179.9, 0.001, 1e-8, 170};
    std::vector<Camera> keys;
    for (const double f : fovy) keys.push_back({.eye = {0, 0, 1.0 + double(keys.size())}, .fovy_deg = f});
    expect_valid(geom::spline(keys), "wide and narrow");
}

TEST(Spline, TakesASecondFromKeyToKeyByDefault) {
    const auto keys = random_keys(4, 1, 4);
    EXPECT_EQ(geom::spline(keys).size(), 73u);
    EXPECT_EQ(geom::spline(keys, {.closed = true}).size(), 96u);
    EXPECT_EQ(geom::spline(keys, {.frames = 1}).size(), 1u);
}

TEST(Spline, RefusesKeysItCannotFollow) {
    using Timing = geom::Spline::Timing;
    auto keys = random_keys(3, 1, 5);
    const std::vector<Camera> one(keys.begin(), keys.begin() + 1), two(keys.begin(), keys.begin() + 2);
    EXPECT_THROW(geom::spline(one), core::Error);
    EXPECT_THROW(geom::spline(two, {.closed = true}), core::Error);
    EXPECT_THROW(geom::spline(keys, {.timing = Timing::keys, .closed = true}), core::Error);
    EXPECT_THROW(geom::spline(keys, {.fps = 1e9}), core::Error);
    keys[2].time_s = keys[1].time_s;
    EXPECT_THROW(geom::spline(keys, {.timing = Timing::keys}), core::Error);
    keys[2].near.reset();
    EXPECT_THROW(geom::spline(keys), core::Error);
}

TEST(Spline, SaysInWhichFrameTheEyeMeetsItsTarget) {
    const std::vector<Camera> keys{{.eye = {0, 0, 1}, .target = {0, 0, 0}},
                                   {.eye = {0, 0, 0}, .target = {0, 0, 1}}};
    try {
        geom::spline(keys, {.frames = 3});
        FAIL() << "the eye passes through its target half way";
    } catch (const core::Error& error) {
        EXPECT_EQ(std::string(error.what()).rfind("frame 1: \"eye\" and \"target\" are the same point", 0),
                  0u)
            << error.what();
    }
}

}  // namespace
