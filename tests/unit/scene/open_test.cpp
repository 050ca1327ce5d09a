// What is not closed: surfaces with two sides, and bare points.
#include <gtest/gtest.h>

#include <cmath>

#include "geom/path.h"
#include "scene/draw.h"
#include "scene/reference.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

// Six sides, none of them along an axis.
const glm::dvec3 kDirections[] = {{0.1, 0.2, 1},    {1, 0.1, -0.2}, {0.2, 1, 0.1},
                                  {-0.1, -0.3, -1}, {-1, 0.2, 0.1}, {0.1, -1, 0.3}};

geom::View view_from(const splat::Model& model, const glm::dvec3& direction) {
    geom::Camera camera;
    camera.target = model.header().origin;
    camera.eye = camera.target + 4.5 * model.header().scale * glm::normalize(direction);
    return geom::make_view(camera, 320, 240);
}

render::Frame draw(const splat::Model& model, const geom::View& view,
                   render::Shade shade = render::Shade::lit) {
    render::Frame frame;
    scene::DrawOptions options;
    options.look.shade = shade;
    scene::ModelPainter(model).draw(view, options, frame);
    return frame;
}

mesh::Mesh points(const std::vector<glm::vec3>& positions) {
    mesh::Mesh mesh;
    mesh.positions = positions;
    return mesh;
}

mesh::Mesh line_of_points() {
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 300; ++i) positions.emplace_back(0.01f * float(i), 0.0f, 0.0f);
    return points(positions);
}

}  // namespace

TEST(OpenSurface, IsRecognisedAndShowsBothSides) {
    mesh::Mesh mesh = terrain(60);
    const splat::Model model = build_model(mesh);
    EXPECT_TRUE(model.header().flags & splat::kOpenSurface);
    scene::Reference reference(mesh, "terrain", true);
    for (const glm::dvec3& direction : kDirections) {
        const geom::View view = view_from(model, direction);
        const render::Frame frame = draw(model, view);
        const scene::ReferenceMeasures measures = reference.measure(view, {}, frame);
        EXPECT_EQ(measures.difference.holes, 0u);
        EXPECT_GT(measures.difference.coverage_iou, 0.9);
    }
}

TEST(OpenSurface, IsNotWhatHasButSmallHoles) {
    mesh::Mesh ball = icosphere(6);
    EXPECT_FALSE(build_model(ball).header().flags & splat::kOpenSurface);
    ball.triangles.pop_back();
    EXPECT_FALSE(build_model(ball).header().flags & splat::kOpenSurface);
    ball.triangles.resize(ball.triangles.size() / 2);
    EXPECT_TRUE(build_model(ball).header().flags & splat::kOpenSurface);
}

// Without a plane through its neighbours a point has no normal: no side of the line is its edge.
TEST(BarePoints, ALineOfThemIsSeenFromEverySide) {
    const splat::Model model = build_model(line_of_points());
    for (const glm::dvec3& direction :
         {glm::dvec3(0, 0, 1), {0, 1, 0.01}, {0, 0, -1}, {0, -1, 0.01}, {0, 1, 1}}) {
        const geom::View view = view_from(model, direction);
        const render::Frame frame = draw(model, view);
        const glm::dvec3 a = view.view_from_world({0.05, 0, 0}), b = view.view_from_world({2.94, 0, 0});
        for (int k = 0; k <= 50; ++k) {
            const glm::dvec3 p = a + (k / 50.0) * (b - a);
            const int x = int(160 + view.focal_px * p.x / p.z), y = int(120 + view.focal_px * p.y / p.z);
            EXPECT_TRUE(std::isfinite(frame.depth[size_t(y * 320 + x)])) << x << ", " << y;
        }
    }
}

TEST(BarePoints, FaceTheViewerWhereTheyHaveNoNormal) {
    for (const mesh::Mesh& mesh : {points({{1, 2, 3}}), points({{1, 2, 3}, {1, 2, 4}}), line_of_points()}) {
        const splat::Model model = build_model(mesh);
        for (const glm::dvec3& direction : kDirections) {
            const render::Frame frame = draw(model, view_from(model, direction));
            size_t covered = 0, dark = 0;
            for (size_t i = 0; i < frame.depth.size(); ++i) {
                if (!std::isfinite(frame.depth[i])) continue;
                ++covered, dark += frame.rgb[3 * i] < 210;
            }
            EXPECT_GT(covered, 50u);
            EXPECT_EQ(dark, 0u) << "lit from the eye";
        }
    }
}

TEST(BarePoints, FaceTheirNormalsWhereTheyHaveThem) {
    mesh::Mesh mesh = points({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
    mesh.normals.assign(4, glm::vec3(0, 0, 1));
    const splat::Model model = build_model(mesh);
    const auto covered = [&](const glm::dvec3& direction) {
        const render::Frame frame = draw(model, view_from(model, direction));
        return std::count_if(frame.depth.begin(), frame.depth.end(),
                             [](float z) { return std::isfinite(z); });
    };
    EXPECT_LT(double(covered({1, 0, 0})), 0.2 * double(covered({0, 0, 1}))) << "discs on edge";
}
