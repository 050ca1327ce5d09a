// A small thing in a large scene, seen from near by: as good as on its own.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "subject.h"
#include "table.h"

namespace stability {
namespace {

// The bumpy sphere, scaled and moved, with something around it.
struct Detail {
    const char* name;
    double scale;
    glm::dvec3 centre;
    std::function<Shape()> around;
    Precision precision;
};

std::ostream& operator<<(std::ostream& out, const Detail& detail) {
    return out << detail.name;
}

// A body of size 1 at `distance` behind the sphere.
Shape island(double distance) {
    return placed(tetrahedron(), 1, distance * glm::dvec3(-0.3, -0.2, -1));
}

// 10 km, its ground at `height`.
Shape ground(double height) {
    return placed(terrain(1e4), 1, {0, height, 0});
}

const Detail kDetails[] = {
    {"beside_island_at_1e3", 1, {0, 0, 0}, [] { return island(1e3); }, Precision::single},
    {"beside_island_at_1e6", 1, {0, 0, 0}, [] { return island(1e6); }, Precision::single},
    {"beside_island_at_1e9", 1, {0, 0, 0}, [] { return island(1e9); }, Precision::single},
    {"beside_island_at_1e3_double", 1, {0, 0, 0}, [] { return island(1e3); }, Precision::twice},
    {"1_m_over_10_km", 0.5, {0, 0, 0}, [] { return ground(-300); }, Precision::single},
    {"1_m_over_10_km_double", 0.5, {0, 0, 0}, [] { return ground(-300); }, Precision::twice},
    {"1_cm_over_10_km", 5e-3, {0, 0, 0}, [] { return ground(-300); }, Precision::single},
};

// What is left of the sphere's own coordinates, rounded in the scene, where it stands alone.
Shape alone(const Detail& detail) {
    Shape shape = placed(bumpy_sphere(), detail.scale, detail.centre);
    for (glm::dvec3& v : shape.vertices)
        for (int k = 0; k < 3; ++k) v[k] = rounded(v[k], detail.precision);
    return shape;
}

class Details : public testing::TestWithParam<Detail> {};

// Of one view, whose other promises are held too.
double psnr_lost(const std::string& row, const Subject& scene, const Subject& lonely,
                 const geom::Camera& camera) {
    scene::DrawOptions options = all_detail();
    options.cut.cull_backfaces = false;
    const Picture near = draw(scene, camera, options), by_itself = draw(lonely, camera, options);
    const render::ImageDifference difference = difference_from_mesh(scene, near);
    expect_at_most(row, "bad pixels", double(bad_pixels(near.frame)), 0);
    expect_at_most(row, "holes", double(difference.holes), 0);
    expect_at_most(row, "error px at 0", measured_error_px(scene, near),
                   near.report.counts.error_bound_px + measurement_rounding_px(near));
    return difference_from_mesh(lonely, by_itself).psnr_inside_db - difference.psnr_inside_db;
}

TEST_P(Details, AreDrawnAsIfAlone) {
    const Detail& detail = GetParam();
    const std::string row = detail.name;
    const Subject lonely = build(alone(detail), detail.precision);
    const Subject scene = build(joined(detail.around(), alone(detail)), detail.precision);
    // The detail's leaves are grouped otherwise beside the scene, which moves the PSNR of a single view by a
    // decibel either way: what counts is the mean over views.
    constexpr int kViews = 8;
    double lost_db = 0;
    for (int k = 0; k < kViews; ++k) {
        const double turn = 2 * std::numbers::pi * k / kViews;
        geom::Camera camera;
        camera.eye = detail.centre +
                     detail.scale * glm::dvec3(4.75 * std::sin(turn + 0.32), 2, 4.75 * std::cos(turn + 0.32));
        camera.target = detail.centre;
        lost_db += psnr_lost(row, scene, lonely, camera) / kViews;
    }
    expect_at_most(row, "psnr db lost against alone", lost_db, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Table, Details, testing::ValuesIn(kDetails), testing::PrintToStringParamName());

}  // namespace
}  // namespace stability
