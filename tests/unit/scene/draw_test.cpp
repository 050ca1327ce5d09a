// ModelPainter: what a frame costs and that it is the same for any number of threads.
#include <gtest/gtest.h>

#include <cmath>

#include "core/parallel.h"
#include "scene/draw.h"
#include "scene/reference.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

TEST(ModelPainter, DrawsTheSameFrameWithAnyNumberOfThreads) {
    const mesh::Mesh mesh = bumpy_torus(60, 160, true);
    const splat::Model model = build_model(mesh);
    std::vector<geom::View> views = random_views(model, mesh, 6);
    views.push_back(fitted_view(model, 640, 480));
    for (const geom::View& view : views)
        for (const render::SplatKind kind : {render::SplatKind::square, render::SplatKind::circle,
                                             render::SplatKind::ellipse, render::SplatKind::smooth}) {
            scene::DrawOptions options;
            options.kind = kind;
            core::set_thread_count(1);
            const Drawn one = draw({{&model}}, view, options);
            for (const int threads : {2, 16}) {
                core::set_thread_count(threads);
                const Drawn many = draw({{&model}}, view, options);
                expect_same(one, many);
            }
        }
    core::set_thread_count(0);
}

TEST(ModelPainter, DrawsTheNextFrameAsIfItWereTheFirst) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    for (const auto occlusion : {scene::Occlusion::automatic, scene::Occlusion::on}) {
        scene::DrawOptions options;
        options.occlusion = occlusion;
        scene::ModelPainter painter(model);
        render::Frame frame;
        for (const geom::View& view : random_views(model, mesh, 8)) {
            const scene::DrawReport report = painter.draw(view, options, frame);
            const Drawn fresh = draw({{&model}}, view, options);
            EXPECT_EQ(frame.rgb, fresh.frame.rgb);
            EXPECT_EQ(frame.depth, fresh.frame.depth);
            // By itself it leaves alone what the frames before say does not pay.
            if (occlusion == scene::Occlusion::on) {
                EXPECT_EQ(report.counts.blocks_touched, fresh.report.counts.blocks_touched);
            }
        }
    }
}

TEST(ModelPainter, GivesDepthsInWorldUnits) {
    for (const double scale : {1e-25, 1.0, 1e6}) {
        const splat::Model model = build_model(scaled(icosphere(4), scale));
        const geom::View view = fitted_view(model);
        const Drawn drawn = draw({{&model}}, view, {});
        const float middle = drawn.frame.depth[size_t(view.height / 2 * view.width + view.width / 2)];
        const double distance = glm::length(view.eye - model.header().origin);
        EXPECT_NEAR(double(middle), distance - scale, 0.02 * scale);
    }
}

// Against the mesh drawn with the same limits: what near cuts open shows its inside, and the limits are seen
// by the walk, too.
TEST(ModelPainter, DrawsOnlyBetweenNearAndFar) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    const geom::View whole = fitted_view(model);
    const double middle = glm::dot(model.header().origin - whole.eye, whole.forward);
    const double reach = model.header().scale;
    scene::Reference reference(mesh, "torus", true);
    const Drawn all = draw({{&model}}, whole, {});
    const std::pair<double, double> limits[] = {{-0.1, 2}, {0, 0.3}, {0.2, 2}, {-2, 0}, {-2, 2}};
    for (const auto& [from, to] : limits) {
        geom::View view = whole;
        view.near = middle + from * reach, view.far = middle + to * reach;
        const Drawn some = draw({{&model}}, view, {});
        for (const float depth : some.frame.depth) {
            if (!std::isfinite(depth)) continue;
            EXPECT_GT(double(depth), *view.near * (1 - 1e-6));
            EXPECT_LT(double(depth), *view.far * (1 + 1e-6));
        }
        const scene::ReferenceMeasures m = reference.measure(view, {}, some.frame);
        EXPECT_GT(m.difference.coverage_iou, 0.95) << from << " to " << to;
        EXPECT_LE(m.measured_error_px, some.report.counts.error_bound_px + 2e-3);
        if (from > -1 || to < 1) {
            EXPECT_GT(some.report.counts.frustum_culled, all.report.counts.frustum_culled) << from;
        } else {
            EXPECT_EQ(some.frame.rgb, all.frame.rgb);
        }
    }
}

TEST(ModelPainter, BoundsTheErrorBesideTheEyeWhereNearKeepsItOff) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    scene::Reference reference(mesh, "torus", true);
    for (geom::View view : close_views(model, mesh, 20)) {
        view.near = 0.05 * model.header().scale;
        const Drawn drawn = draw({{&model}}, view, {});
        EXPECT_TRUE(std::isfinite(drawn.report.counts.error_bound_px));
        const scene::ReferenceMeasures m = reference.measure(view, {}, drawn.frame);
        EXPECT_LE(m.measured_error_px, drawn.report.counts.error_bound_px + 2e-3);
    }
}

TEST(ModelPainter, PromisesNoBoundForSplatsThatLeaveTheirEllipsoids) {
    const splat::Model model = build_model(icosphere(4));
    scene::DrawOptions options;
    for (const render::SplatKind kind : {render::SplatKind::square, render::SplatKind::circle}) {
        options.kind = kind;
        EXPECT_TRUE(std::isinf(draw({{&model}}, fitted_view(model), options).report.counts.error_bound_px));
    }
}

TEST(ModelPainter, DrawsMoreWhereMoreIsAsked) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    scene::DrawOptions options;
    uint64_t last = 0;
    for (const double threshold_px : {16.0, 4.0, 1.0}) {
        options.cut.threshold_px = threshold_px;
        const uint64_t splats = draw({{&model}}, fitted_view(model), options).report.counts.splats;
        EXPECT_GT(splats, last) << threshold_px;
        last = splats;
    }
    options.cut.threshold_px = 0;
    options.cut.cull_backfaces = false;
    const Drawn all = draw({{&model}}, fitted_view(model), options);
    EXPECT_EQ(all.report.counts.splats, model.header().leaf_count);
    EXPECT_EQ(all.report.counts.backface_culled, 0u);
}
