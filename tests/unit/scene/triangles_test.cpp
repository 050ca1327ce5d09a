// Models whose leaves are triangles, as drawn: no cracks however near the eye is, no holes where triangles
// and splats meet, and pictures close to the mesh's.
#include <gtest/gtest.h>

#include <cmath>

#include "core/parallel.h"
#include "render/raster.h"
#include "scene/draw.h"
#include "scene/reference.h"
#include "splat/extract.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

constexpr splat::BuildOptions kTriangles{.leaf = splat::Leaf::triangle};

scene::DrawOptions options_of(double threshold_px, double triangle_px,
                              render::SplatKind kind = render::SplatKind::smooth) {
    scene::DrawOptions options;
    options.cut.threshold_px = threshold_px;
    options.cut.triangle_px = triangle_px;
    options.kind = kind;
    return options;
}

geom::View view_of(const glm::dvec3& eye, const glm::dvec3& target, double fovy_deg, int width, int height) {
    geom::Camera camera;
    camera.eye = eye, camera.target = target, camera.fovy_deg = fovy_deg;
    return geom::make_view(camera, width, height);
}

uint64_t background_of(const render::Frame& frame) {
    uint64_t count = 0;
    for (const float depth : frame.depth) count += !std::isfinite(depth);
    return count;
}

// The mesh that the model's leaves are, on their lattice.
mesh::Mesh leaves_of(const splat::Model& model) {
    char folder[] = "/tmp/triangles-test-XXXXXX";
    if (!::mkdtemp(folder)) std::abort();
    const std::string path = std::string(folder) + "/leaves.ply";
    {
        core::OutputFile out(path);
        splat::write_cut(model, model.header().level_count, out);
        out.commit();
    }
    mesh::Mesh mesh = mesh::read_mesh(path).mesh;
    std::remove(path.c_str()), ::rmdir(folder);
    return mesh;
}

}  // namespace

// The surface fills each of these pictures, 1000 times as large as where all of the model is seen, with
// vertices and edges all over it.
TEST(Triangles, OfAClosedMeshHaveNoCracksAt1000TimesMagnification) {
    const mesh::Mesh mesh = bumpy_torus(300, 700);
    const splat::Model model = build_model(mesh, kTriangles);
    scene::ModelPainter painter(model);
    const splat::Header& h = model.header();
    Random random(1);
    uint64_t triangles = 0;
    for (int i = 0; i < 60; ++i) {
        const glm::u32vec3 t = mesh.triangles[random.bits() % mesh.triangles.size()];
        const glm::dvec3 a = mesh.world(t.x), b = mesh.world(t.y), c = mesh.world(t.z);
        // A vertex, the middle of an edge, or of the triangle; seen from its side, more or less aslant.
        const glm::dvec3 target = i % 3 == 0 ? a : i % 3 == 1 ? 0.5 * (a + b) : (a + b + c) / 3.0;
        const glm::dvec3 n = glm::normalize(glm::cross(b - a, c - a));
        const glm::dvec3 towards = glm::normalize(n + 0.6 * random.unit() * random.direction());
        const geom::View view = view_of(target + 3e-3 * h.scale * towards, target, 30, 320, 240);
        for (const double triangle_px : {0.0, 4.0}) {
            render::Frame frame;
            const scene::DrawReport report = painter.draw(view, options_of(1, triangle_px), frame);
            triangles += report.counts.triangles;
            EXPECT_EQ(background_of(frame), 0u) << i << ", triangles from " << triangle_px;
        }
    }
    EXPECT_GT(triangles, 300u) << "there are edges and vertices in the pictures";
}

// Where the mesh on the lattice covers a pixel, the model does, whatever is splat and whatever triangle.
TEST(Triangles, MeetSplatsWithoutHolesAtAnyThreshold) {
    for (const NamedMesh& m :
         {NamedMesh{"torus", bumpy_torus(60, 160)}, {"terrain", terrain(60)}, {"ball", icosphere(4)}}) {
        const splat::Model model = build_model(m.mesh, kTriangles);
        const mesh::Mesh leaves = leaves_of(model);
        scene::ModelPainter painter(model);
        render::MeshRaster raster(leaves);
        const splat::Header& h = model.header();
        for (const double distance : {6.0, 2.5, 1.2}) {
            const geom::View view =
                view_of(h.origin + h.scale * distance * glm::dvec3(0.48, 0.6, 0.64), h.origin, 40, 320, 240);
            render::Frame exact;
            raster.draw(view, {}, exact);
            for (const double triangle_px : {0.0, 2.0, 4.0, 8.0, 16.0})
                for (const double threshold_px : {0.0, 1.0, 4.0}) {
                    render::Frame frame;
                    painter.draw(view, options_of(threshold_px, triangle_px), frame);
                    uint64_t holes = 0;
                    for (size_t i = 0; i < frame.depth.size(); ++i)
                        holes += std::isfinite(exact.depth[i]) && !std::isfinite(frame.depth[i]);
                    EXPECT_EQ(holes, 0u) << m.name << ", distance " << distance << ", triangles from "
                                         << triangle_px << ", threshold " << threshold_px;
                }
        }
    }
}

// All leaves as triangles are the mesh on the lattice, pixel for pixel.
TEST(Triangles, OfAllLeavesCoverWhatTheMeshOnTheLatticeCovers) {
    const splat::Model model = build_model(bumpy_torus(60, 160), kTriangles);
    const mesh::Mesh leaves = leaves_of(model);
    const splat::Header& h = model.header();
    const geom::View view =
        view_of(h.origin + h.scale * 2.5 * glm::dvec3(0.48, 0.6, 0.64), h.origin, 40, 640, 480);
    render::Frame exact, frame;
    render::MeshRaster(leaves).draw(view, {}, exact);
    scene::ModelPainter(model).draw(view, options_of(0, 0), frame);
    uint64_t different = 0;
    for (size_t i = 0; i < frame.depth.size(); ++i)
        different += std::isfinite(exact.depth[i]) != std::isfinite(frame.depth[i]);
    EXPECT_LE(different, 4u) << "corners are rounded to single precision";
}

TEST(Triangles, OfCloseViewsAreAsTheMesh) {
    mesh::Mesh mesh = bumpy_torus(200, 400);
    const splat::Model triangles = build_model(mesh, kTriangles), points = build_model(mesh);
    scene::Reference reference(mesh, "torus", true);
    scene::ModelPainter of_triangles(triangles), of_points(points);
    const splat::Header& h = triangles.header();
    const geom::View view = view_of(h.origin + h.scale * 1.3 * glm::dvec3(0.48, 0.6, 0.64),
                                    h.origin + h.scale * glm::dvec3(0.3, 0.3, 0), 10, 640, 480);
    const auto psnr = [&](scene::ModelPainter& painter) {
        render::Frame frame;
        const scene::DrawOptions options = options_of(1, scene::kTrianglePx);
        const scene::DrawReport report = painter.draw(view, options, frame);
        const scene::ReferenceMeasures measures = reference.measure(view, options.look, frame);
        EXPECT_LE(measures.measured_error_px, report.counts.error_bound_px + 2e-3 + 1e-6 * view.height);
        return measures.difference.psnr_db;
    };
    const double with_triangles = psnr(of_triangles), without = psnr(of_points);
    EXPECT_GT(with_triangles, 45);
    EXPECT_GT(with_triangles, without + 8);
}

TEST(Triangles, AreTheSameForAnyNumberOfThreads) {
    const splat::Model model = build_model(bumpy_torus(200, 300, true), kTriangles);
    const splat::Header& h = model.header();
    const geom::View view =
        view_of(h.origin + h.scale * 4.0 * glm::dvec3(0.48, 0.6, 0.64), h.origin, 30, 640, 480);
    render::Frame one, many;
    core::set_thread_count(1);
    const scene::DrawReport report = scene::ModelPainter(model).draw(view, options_of(1, 4), one);
    core::set_thread_count(7);
    scene::ModelPainter(model).draw(view, options_of(1, 4), many);
    core::set_thread_count(0);
    EXPECT_GT(report.counts.triangles, 0u);
    EXPECT_GT(report.counts.splats, 0u);
    EXPECT_EQ(one.rgb, many.rgb);
    EXPECT_EQ(one.depth, many.depth);
}

TEST(Triangles, AreLeftOutWhereTheyAreHiddenAndNoPixelChanges) {
    const splat::Model model = build_model(bumpy_torus(200, 300), kTriangles);
    const splat::Header& h = model.header();
    for (const double distance : {1.5, 3.0}) {
        const geom::View view =
            view_of(h.origin + h.scale * distance * glm::dvec3(0.9, 0.1, 0.42), h.origin, 30, 640, 480);
        scene::DrawOptions options = options_of(1, 4);
        render::Frame all, seen;
        options.occlusion = scene::Occlusion::off;
        scene::ModelPainter(model).draw(view, options, all);
        options.occlusion = scene::Occlusion::on;
        scene::ModelPainter(model).draw(view, options, seen);
        EXPECT_EQ(all.rgb, seen.rgb) << distance;
        EXPECT_EQ(all.depth, seen.depth) << distance;
    }
}
