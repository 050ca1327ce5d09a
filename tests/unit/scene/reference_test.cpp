// Reference: measures of frames whose errors are known.
#include "scene/reference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/parallel.h"
#include "geom/path.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A square of side 20 in the plane z = 0.
mesh::Mesh plane() {
    mesh::Mesh m;
    m.positions = {{-10, -10, 0}, {10, -10, 0}, {10, 10, 0}, {-10, 10, 0}};
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    return m;
}

geom::View view_of_plane() {
    geom::Camera camera;
    camera.eye = {0, 0, 4};
    return geom::make_view(camera, 64, 48);
}

render::Frame drawn(const mesh::Mesh& mesh, const geom::View& view) {
    render::Frame frame;
    render::MeshRaster(mesh).draw(view, {}, frame);
    return frame;
}

scene::ReferenceMeasures measure(const render::Frame& frame) {
    return scene::Reference(plane(), "plane", true).measure(view_of_plane(), {}, frame);
}

}  // namespace

TEST(Reference, FindsNoErrorInItsOwnPicture) {
    const mesh::Mesh mesh = bumpy_torus(60, 160, true);
    geom::Camera camera;
    camera.eye = {1, 2, 4};
    const geom::View view = geom::make_view(camera, 160, 120);
    scene::Reference reference(mesh, "torus", true);
    const scene::ReferenceMeasures m = reference.measure(view, {}, drawn(mesh, view));
    EXPECT_TRUE(std::isinf(m.difference.psnr_db));
    EXPECT_EQ(m.difference.holes, 0u);
    EXPECT_EQ(m.difference.silhouette_growth, 0);
    EXPECT_LT(m.measured_error_px, 1e-4);  // a depth in single precision, as projected
}

TEST(Reference, MeasuresOnePixelThatIsTooNear) {
    const geom::View view = view_of_plane();
    render::Frame frame = drawn(plane(), view);
    frame.depth[64 * 24 + 32] = 3;
    // The point is on the ray, at depth 3; the plane is the whole difference of depth away.
    EXPECT_NEAR(measure(frame).measured_error_px, 1 * view.focal_px / 3, 1e-4);
}

TEST(Reference, CountsHolesWithoutTakingThemForErrors) {
    render::Frame frame = drawn(plane(), view_of_plane());
    frame.depth[0] = frame.depth[100] = kInfinity;
    const scene::ReferenceMeasures m = measure(frame);
    EXPECT_EQ(m.difference.holes, 2u);
    EXPECT_LT(m.measured_error_px, 1e-4);
}

TEST(Reference, TakesAPointThatIsNotFiniteForAnInfiniteError) {
    render::Frame frame = drawn(plane(), view_of_plane());
    frame.depth[7] = 0;
    EXPECT_TRUE(std::isinf(measure(frame).measured_error_px));
}

TEST(Reference, MeasuresNothingWhereNothingIsCovered) {
    render::Frame frame;
    frame.resize(64, 48);
    EXPECT_EQ(measure(frame).measured_error_px, 0);
}

TEST(Reference, MeasuresTheSameWithAnyNumberOfThreads) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    geom::Camera camera;
    camera.eye = {1, 2, 4};
    const geom::View view = geom::make_view(camera, 160, 120);
    render::Frame frame = drawn(mesh, view);
    for (float& depth : frame.depth) depth *= 1.01f;
    double expected = 0;
    for (const int threads : {1, 2, 16}) {
        core::set_thread_count(threads);
        scene::Reference reference(mesh, "torus", true);
        const double error_px = reference.measure(view, {}, frame).measured_error_px;
        if (threads == 1) expected = error_px;
        EXPECT_GT(error_px, 0);
        EXPECT_EQ(error_px, expected);
    }
    core::set_thread_count(0);
}

TEST(Reference, RefusesACloud) {
    try {
        scene::Reference(cloud(100), "points.ply", true);
        FAIL();
    } catch (const core::Error& error) {
        EXPECT_STREQ(error.what(), "points.ply: has no triangles; a reference must be a mesh with faces");
    }
}

TEST(Reference, IsGreyForAModelWithoutColour) {
    mesh::Mesh mesh = plane();
    mesh.colours.assign(4, {255, 0, 0});
    const geom::View view = view_of_plane();
    for (const bool with_colour : {true, false}) {
        scene::Reference reference(mesh, "plane", with_colour);
        EXPECT_EQ(reference.has_colour(), with_colour);
        reference.measure(view, {render::Shade::flat}, drawn(mesh, view));
        const uint8_t* rgb = reference.frame().rgb.data();
        EXPECT_EQ(rgb[0], with_colour ? 255 : 230);
        EXPECT_EQ(rgb[1], with_colour ? 0 : 230);
    }
}

TEST(PointOfPixel, IsProjectedToThePixelsCentre) {
    geom::Camera camera;
    camera.eye = {3, -2, 5}, camera.target = {0.5, 1, -1};
    const geom::View view = geom::make_view(camera, 160, 120);
    render::Frame frame;
    frame.resize(160, 120);
    std::fill(frame.depth.begin(), frame.depth.end(), 2.5f);
    for (const auto& [x, y] : {std::pair{0, 0}, {159, 119}, {80, 60}, {3, 77}}) {
        const glm::dvec3 p = view.view_from_world(scene::point_of_pixel(view, frame, x, y));
        EXPECT_NEAR(p.z, 2.5, 1e-12);
        EXPECT_NEAR(view.width / 2.0 + view.focal_px * p.x / p.z, x + 0.5, 1e-9);
        EXPECT_NEAR(view.height / 2.0 + view.focal_px * p.y / p.z, y + 0.5, 1e-9);
    }
}
