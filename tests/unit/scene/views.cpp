#include "views.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geom/path.h"
#include "test_meshes.h"

namespace scene_test {

namespace {

constexpr int kWidth = 160, kHeight = 120;

struct SurfacePoint {
    glm::dvec3 at, normal;  // of the face
};

SurfacePoint random_point(const mesh::Mesh& mesh, splat_test::Random& random) {
    const glm::u32vec3 t = mesh.triangles[random.bits() % mesh.triangles.size()];
    double u = random.unit(), v = random.unit();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const glm::dvec3 a = mesh.world(t.x), b = mesh.world(t.y), c = mesh.world(t.z);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double length = glm::length(normal);
    return {a + u * (b - a) + v * (c - a), length > 0 ? normal / length : glm::dvec3(0, 0, 1)};
}

geom::View view_from(const glm::dvec3& eye, const glm::dvec3& target, double fovy_deg) {
    geom::Camera camera;
    camera.eye = eye, camera.target = target, camera.fovy_deg = fovy_deg;
    return geom::make_view(camera, kWidth, kHeight);
}

}  // namespace

geom::View fitted_view(const splat::Model& model, int width, int height) {
    const splat::Header& h = model.header();
    const geom::Shot shot{.frames = 1, .aspect = double(width) / height};
    return geom::make_view(geom::orbit({h.origin, h.scale}, shot).front(), width, height);
}

std::vector<geom::View> random_views(const splat::Model& model, const mesh::Mesh& mesh, int count) {
    splat_test::Random random(21);
    const splat::Header& h = model.header();
    std::vector<geom::View> views;
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 target = random_point(mesh, random).at;
        const double distance = 1.001 + std::pow(random.unit(), 3) * 9;
        const double fovy_deg = 60 * std::pow(1e-3, random.unit());
        views.push_back(view_from(h.origin + h.scale * distance * random.direction(), target, fovy_deg));
    }
    return views;
}

std::vector<geom::View> close_views(const splat::Model& model, const mesh::Mesh& mesh, int count) {
    splat_test::Random random(22);
    std::vector<geom::View> views;
    for (int i = 0; i < count; ++i) {
        const SurfacePoint point = random_point(mesh, random);
        const double height = model.header().scale * 1e-3 * std::pow(300, random.unit());
        const glm::dvec3 aside = height * random.direction();
        views.push_back(view_from(point.at + height * point.normal, point.at + 0.5 * aside, 40));
    }
    return views;
}

Drawn draw(const std::vector<scene::PlacedModel>& models, const geom::View& view,
           const scene::DrawOptions& options) {
    Drawn drawn;
    drawn.report = scene::ModelPainter(models).draw(view, options, drawn.frame);
    return drawn;
}

void expect_same(const Drawn& a, const Drawn& b) {
    EXPECT_EQ(a.frame.rgb, b.frame.rgb);
    EXPECT_EQ(a.frame.depth, b.frame.depth);
    const splat::CutCounts &of_a = a.report.counts, &of_b = b.report.counts;
    EXPECT_EQ(of_a.splats, of_b.splats);
    EXPECT_EQ(of_a.nodes_visited, of_b.nodes_visited);
    EXPECT_EQ(of_a.occlusion_culled, of_b.occlusion_culled);
    EXPECT_EQ(of_a.blocks_touched, of_b.blocks_touched);
    EXPECT_EQ(of_a.error_bound_px, of_b.error_bound_px);
}

}  // namespace scene_test
