// The same surface far from the origin, very small and very large: same bounds, same picture.
#include <gtest/gtest.h>

#include <cmath>

#include "render/compare.h"
#include "splat/verify.h"
#include "subject.h"
#include "table.h"

namespace stability {
namespace {

struct Place {
    double scale, offset;
    Precision precision;
};

std::string power(const char* word, double value) {
    const int exponent = int(std::lround(std::log10(value)));
    return word + std::string(exponent < 0 ? "m" : "") + std::to_string(std::abs(exponent));
}

std::string name_of_place(const Place& place) {
    std::string name = place.offset > 0 ? power("offset_1e", place.offset) : power("scale_1e", place.scale);
    if (place.precision == Precision::twice) name += "_double";
    return name;
}

std::ostream& operator<<(std::ostream& out, const Place& place) {
    return out << name_of_place(place);
}

constexpr glm::dvec3 kDirection{1, -0.7, 0.4};

std::vector<Place> places() {
    std::vector<Place> all;
    for (const double offset : {1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12})
        all.push_back({1, offset, Precision::twice});
    for (const double offset : {1e3, 1e4, 1e5, 1e6, 1e7, 1e12}) all.push_back({1, offset, Precision::single});
    for (const Precision precision : {Precision::single, Precision::twice})
        for (const double scale :
             {1e-30, 1e-25, 1e-20, 1e-15, 1e-10, 1e-5, 1e5, 1e10, 1e15, 1e20, 1e25, 1e30})
            all.push_back({scale, 0, precision});
    return all;
}

// What is left of the unit shape once its coordinates were rounded at the place, taken back to 0: the
// rounding is the file's, and not ours.
Shape as_rounded_there(const Place& place) {
    const glm::dvec3 offset = place.offset * kDirection;
    Shape shape = placed(bumpy_sphere(), place.scale, offset);
    for (glm::dvec3& v : shape.vertices)
        for (int k = 0; k < 3; ++k) v[k] = (rounded(v[k], place.precision) - offset[k]) / place.scale;
    return shape;
}

class Places : public testing::TestWithParam<Place> {};

TEST_P(Places, ShowTheSamePicture) {
    const Place& place = GetParam();
    const std::string row = name_of_place(place);
    const glm::dvec3 offset = place.offset * kDirection;
    const Subject here = build(as_rounded_there(place), Precision::twice);
    Shape shape = placed(bumpy_sphere(), place.scale, offset);
    for (glm::dvec3& v : shape.vertices)
        for (int k = 0; k < 3; ++k) v[k] = rounded(v[k], place.precision);
    const Subject there = build(shape, place.precision);

    EXPECT_NO_THROW(splat::verify(nameless_file(there.bytes))) << row;
    expect_at_most(row, "vertex outside / radius", worst_uncovered_vertex(there), 4 * 0x1p-24);
    expect_at_most(row, "worst leaf inflation", double(there.report.fit.worst_leaf_inflation), 3);

    geom::Camera camera;
    camera.eye = offset + place.scale * glm::dvec3(1.5, 2, 4.5);
    camera.target = offset;
    const Picture picture = draw(there, camera, all_detail());
    camera.eye = (camera.eye - offset) / place.scale;
    camera.target = glm::dvec3(0);
    const Picture unit = draw(here, camera, all_detail());
    expect_at_most(row, "bad pixels", double(bad_pixels(picture.frame)), 0);
    expect_at_most(row, "holes", double(difference_from_mesh(there, picture).holes), 0);
    expect_at_most(row, "error px at 0", measured_error_px(there, picture),
                   picture.report.counts.error_bound_px + measurement_rounding_px(picture));
    // Below a hundred thousandth of the coordinates nothing is left of the shape.
    if (covered_pixels(unit.frame) == 0) return;
    // Cuts of the tree that are ties may fall to the other side, so the pictures are held against the truth.
    expect_at_most(row, "psnr db lost against unit",
                   difference_from_mesh(here, unit).psnr_db - difference_from_mesh(there, picture).psnr_db,
                   0.5);
    expect_at_least(row, "iou with unit",
                    render::compare(picture.frame, unit.frame, unit.view.focal_px).coverage_iou, 0.99);
}

INSTANTIATE_TEST_SUITE_P(Table, Places, testing::ValuesIn(places()), testing::PrintToStringParamName());

}  // namespace
}  // namespace stability
