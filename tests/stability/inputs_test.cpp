// Inputs that break builders: each builds and keeps its bounds, or is refused in one sentence.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/error.h"
#include "splat/verify.h"
#include "subject.h"
#include "table.h"

namespace stability {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A leaf's ellipsoid is fitted in single precision: a vertex may be outside of it by a few roundings of
// the model's radius.
constexpr double kPositionBound = 4 * 0x1p-24;
// The builder puts a level between where a code is 2.5 times too large; the smallest code is not always in
// reach.  (On scans the aim is 3, and met.)
constexpr double kLeafInflation = 3.5;

struct Input {
    const char* name;
    std::function<Shape()> shape;
    Precision precision = Precision::single;
    bool skip_bad = false;
    // False where it is thinner than a pixel seen from where it fits, and so may fall between pixel centres.
    bool is_seen = true;
};

std::ostream& operator<<(std::ostream& out, const Input& input) {
    return out << input.name;
}

Shape cloud(std::vector<glm::dvec3> points) {
    return {std::move(points), {}};
}

Shape with_vertex(Shape shape, size_t index, double value) {
    shape.vertices[index].y = value;
    return shape;
}

Shape one_point() {
    return cloud({{4, 5, 6}});
}

Shape two_points() {
    return cloud({{0, 0, 0}, {1, 0, 0}});
}

Shape one_triangle() {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
}

Shape equal_points(double at) {
    return cloud(std::vector<glm::dvec3>(500, glm::dvec3(at, 2 * at, 3 * at)));
}

Shape equal_vertices() {
    return placed(bumpy_sphere(), 0, {1, 2, 3});
}

Shape line() {
    Shape shape;
    for (int k = 0; k < 1000; ++k) shape.vertices.emplace_back(1e-3 * k, 0, 0);
    return shape;
}

Shape bumpy_cloud() {
    return cloud(bumpy_sphere().vertices);
}

Shape third_equal() {
    Shape shape = bumpy_cloud();
    for (size_t v = 0; v < shape.vertices.size(); v += 3) shape.vertices[v] = {0.5, 0.5, 0.5};
    return shape;
}

Shape with_outlier(Shape shape, double distance) {
    shape.vertices.emplace_back(distance, 0.3 * distance, -0.2 * distance);
    return shape;
}

// The outlier is a corner of one large triangle.
Shape with_outlier_triangle(double distance) {
    Shape shape = with_outlier(bumpy_sphere(), distance);
    shape.triangles.push_back({uint32_t(shape.vertices.size()) - 1, 0, 1});
    return shape;
}

Shape with_degenerate_and_duplicate_faces() {
    Shape shape = bumpy_sphere();
    const size_t count = shape.triangles.size();
    for (size_t f = 0; f < count; f += 7) shape.triangles.push_back(shape.triangles[f]);
    for (uint32_t v = 0; v < 500; ++v) {
        const auto copy = uint32_t(shape.vertices.size());
        shape.vertices.push_back(shape.vertices[v]);
        shape.triangles.push_back({v, copy, v + 1});  // no area, with three names
        shape.triangles.push_back({v, v, v + 1});     // names a vertex twice
        shape.triangles.push_back({v, v + 1, v + 2});
    }
    return shape;
}

Shape with_unreferenced() {
    Shape shape = bumpy_sphere();
    for (int k = 0; k < 1000; ++k) shape.vertices.emplace_back(1e9 * k, -1e20, kPositionBound);
    return shape;
}

// 1 mm on 10 km, in metres; the small one lies at the origin of the coordinates, where floats are dense.
Shape millimetre_on_terrain() {
    return joined(terrain(1e4), placed(bumpy_sphere(), 5e-4, {0, 0, 0}));
}
Shape millimetre_on_far_terrain() {
    return joined(placed(terrain(1e4), 1, {5e5, 0, 5e6}),
                  placed(bumpy_sphere(), 5e-4, {503000, 100, 4998000}));
}

const Input kInputs[] = {
    {"one_nan_vertex_skipped", [] { return with_vertex(bumpy_sphere(), 700, kNan); }, Precision::single,
     true},
    {"one_infinite_vertex_skipped", [] { return with_vertex(bumpy_sphere(), 700, -kInfinity); },
     Precision::twice, true},
    {"all_points_equal", [] { return equal_points(1); }, Precision::single, false, false},
    {"all_points_equal_at_0", [] { return equal_points(0); }, Precision::single, false, false},
    {"all_vertices_equal", [] { return equal_vertices(); }, Precision::single, false, false},
    {"third_of_points_equal", [] { return third_equal(); }},
    {"one_vertex", [] { return one_point(); }, Precision::single, false, false},
    {"two_vertices", [] { return two_points(); }},
    {"one_triangle", [] { return one_triangle(); }},
    {"four_vertices", [] { return tetrahedron(); }},
    {"four_points", [] { return cloud(tetrahedron().vertices); }},
    {"points_on_a_line", [] { return line(); }, Precision::single, false, false},
    {"outlier_1e6", [] { return with_outlier_triangle(1e6); }},
    {"outlier_1e30", [] { return with_outlier_triangle(1e30); }},
    {"outlier_1e6_double", [] { return with_outlier_triangle(1e6); }, Precision::twice},
    {.name = "outlier_point_1e6", .shape = [] { return with_outlier(bumpy_cloud(), 1e6); }, .is_seen = false},
    {.name = "outlier_point_1e30",
     .shape = [] { return with_outlier(bumpy_cloud(), 1e30); },
     .is_seen = false},
    {"halving_spacing_30", [] { return halving_spacing(30); }},
    {"halving_spacing_120", [] { return halving_spacing(120); }},
    {"halving_spacing_120_double", [] { return halving_spacing(120); }, Precision::twice},
    {"halving_spacing_points", [] { return cloud(halving_spacing(100).vertices); }},
    {"slivers_1e9", [] { return slivers(300, 1e9); }},
    {"slivers_1e9_double", [] { return slivers(300, 1e9); }, Precision::twice},
    {"slivers_1e3", [] { return slivers(300, 1e3); }},
    {"degenerate_and_duplicate_faces", [] { return with_degenerate_and_duplicate_faces(); }},
    {"unreferenced_vertices", [] { return with_unreferenced(); }},
    {"1_mm_on_10_km", [] { return millimetre_on_terrain(); }},
    {"1_mm_on_10_km_double", [] { return millimetre_on_terrain(); }, Precision::twice},
    {"1_mm_on_10_km_at_map_coordinates", [] { return millimetre_on_far_terrain(); }, Precision::twice},
};

class Inputs : public testing::TestWithParam<Input> {};

TEST_P(Inputs, KeepTheirBounds) {
    const Input& input = GetParam();
    const Subject subject = build(input.shape(), input.precision, {.skip_bad = input.skip_bad});
    const std::string row = input.name;

    EXPECT_NO_THROW(splat::verify(nameless_file(subject.bytes))) << row;
    expect_at_most(row, "vertex outside / radius", worst_uncovered_vertex(subject), kPositionBound);
    expect_at_most(row, "worst leaf inflation", double(subject.report.fit.worst_leaf_inflation),
                   kLeafInflation);

    const geom::Camera camera = fitted_camera(subject);
    const Picture full = draw(subject, camera, all_detail());
    expect_at_most(row, "bad pixels", double(bad_pixels(full.frame)), 0);
    expect_at_least(row, "covered pixels", double(covered_pixels(full.frame)), input.is_seen ? 1 : 0);
    if (!subject.mesh.is_cloud())
        expect_at_most(row, "holes", double(difference_from_mesh(subject, full).holes), 0);
    for (const double threshold_px : {0.0, 1.0, 8.0}) {
        scene::DrawOptions options = all_detail();
        options.cut.threshold_px = threshold_px;
        const Picture picture = draw(subject, camera, options);
        const double bound = picture.report.counts.error_bound_px;
        EXPECT_TRUE(std::isfinite(bound)) << "the eye is outside of the model";
        expect_at_most(row, "error px at " + std::to_string(int(threshold_px)),
                       measured_error_px(subject, picture), bound + measurement_rounding_px(picture));
    }
}

// Those that have triangles.
class TriangleInputs : public Inputs {};

std::vector<Input> inputs_with_triangles() {
    std::vector<Input> inputs;
    for (const Input& input : kInputs)
        if (!input.shape().triangles.empty()) inputs.push_back(input);
    return inputs;
}

// With triangles as leaves: none is lost, all of them are drawn, and the lattice is within the bound.
TEST_P(TriangleInputs, KeepTheirBounds) {
    const Input& input = GetParam();
    const Subject subject =
        build(input.shape(), input.precision, {.skip_bad = input.skip_bad}, splat::Leaf::triangle);
    const std::string row = std::string(input.name) + "_as_triangles";

    EXPECT_NO_THROW(splat::verify(nameless_file(subject.bytes))) << row;
    EXPECT_EQ(subject.model->header().leaf_count, subject.mesh.triangles.size()) << row;
    const geom::Camera camera = fitted_camera(subject);
    for (const double triangle_px : {0.0, scene::kTrianglePx, 1e6}) {
        scene::DrawOptions options = all_detail();
        options.cut.triangle_px = triangle_px;
        const Picture picture = draw(subject, camera, options);
        expect_at_most(row, "bad pixels", double(bad_pixels(picture.frame)), 0);
        // Outlines are off by the lattice's rounding, a small part of a pixel; of slivers they are long.
        expect_at_most(row, "holes", double(difference_from_mesh(subject, picture).holes), 10);
        expect_at_most(row, "error px", measured_error_px(subject, picture),
                       picture.report.counts.error_bound_px + measurement_rounding_px(picture));
    }
}

INSTANTIATE_TEST_SUITE_P(Table, Inputs, testing::ValuesIn(kInputs), testing::PrintToStringParamName());
INSTANTIATE_TEST_SUITE_P(Table, TriangleInputs, testing::ValuesIn(inputs_with_triangles()),
                         testing::PrintToStringParamName());

struct Refusal {
    const char* name;
    std::function<Shape()> shape;
    Precision precision;
    bool skip_bad;
    const char* says;
};

std::ostream& operator<<(std::ostream& out, const Refusal& refusal) {
    return out << refusal.name;
}

const Refusal kRefusals[] = {
    {"nan_vertex", [] { return with_vertex(bumpy_sphere(), 700, kNan); }, Precision::single, false,
     "vertex 700: coordinate is not finite"},
    {"nan_vertex_double", [] { return with_vertex(bumpy_sphere(), 701, kNan); }, Precision::twice, false,
     "vertex 701: coordinate is not finite"},
    {"infinite_vertex", [] { return with_vertex(bumpy_sphere(), 2401, kInfinity); }, Precision::single, false,
     "vertex 2401: coordinate is not finite"},
    {"beyond_single_precision", [] { return with_vertex(bumpy_sphere(), 3, 1e300); }, Precision::twice, false,
     "vertex 3: "},
    {"only_nan_points",
     [] {
         return cloud(std::vector<glm::dvec3>(9, {kNan, 0, 0}));
     },
     Precision::single, true, "no vert"},
    {"no_vertices", [] { return Shape(); }, Precision::single, false, "no vert"},
};

class Refusals : public testing::TestWithParam<Refusal> {};

TEST_P(Refusals, SayWhyInOneLine) {
    const Refusal& refusal = GetParam();
    try {
        build(refusal.shape(), refusal.precision, {.skip_bad = refusal.skip_bad});
        FAIL() << "it was built";
    } catch (const core::Error& error) {
        const std::string message = error.what();
        EXPECT_NE(message.find(refusal.says), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
}

INSTANTIATE_TEST_SUITE_P(Table, Refusals, testing::ValuesIn(kRefusals), testing::PrintToStringParamName());

}  // namespace
}  // namespace stability
