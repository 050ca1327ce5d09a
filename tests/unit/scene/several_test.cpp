// Several models in one scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "geom/path.h"
#include "render/compare.h"
#include "scene/draw.h"
#include "scene/reference.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

geom::View view_of(const std::vector<scene::PlacedModel>& models) {
    return geom::make_view(geom::orbit(scene::bounds_of(models), {.frames = 1, .aspect = 4.0 / 3}).front(),
                           320, 240);
}

double psnr_db(const Drawn& a, const Drawn& b) {
    return render::compare(a.frame, b.frame, 1).psnr_db;
}

// The faces whose first corner is on one side of a plane.
mesh::Mesh half_of(mesh::Mesh mesh, bool left) {
    std::vector<glm::u32vec3> kept;
    for (const glm::u32vec3& t : mesh.triangles)
        if ((mesh.positions[t.x].x < 0) == left) kept.push_back(t);
    mesh.triangles = kept;
    return mesh;
}

}  // namespace

TEST(SeveralModels, PartsOfAModelLookLikeTheWhole) {
    const mesh::Mesh mesh = bumpy_torus(120, 320, true);
    const splat::Model whole = build_model(mesh), left = build_model(half_of(mesh, true)),
                       right = build_model(half_of(mesh, false));
    const geom::View view = view_of({{&whole}});
    scene::Reference reference(mesh, "torus", true);
    const auto psnr_to_mesh_db = [&](const std::vector<scene::PlacedModel>& models) {
        const Drawn drawn = draw(models, view);
        return reference.measure(view, {}, drawn.frame).difference.psnr_db;
    };
    EXPECT_GT(psnr_to_mesh_db({{&left}, {&right}}), psnr_to_mesh_db({{&whole}}) - 1);
    EXPECT_LT(psnr_to_mesh_db({{&left}}), psnr_to_mesh_db({{&whole}}) - 10);
}

TEST(SeveralModels, ReportTheirSumsAndTheLargestBound) {
    const splat::Model ball = build_model(icosphere(4)), torus = build_model(bumpy_torus(60, 160));
    const std::vector<scene::PlacedModel> both{{&ball}, {&torus}};
    const geom::View view = view_of(both);
    scene::DrawOptions options;
    options.occlusion = scene::Occlusion::off;
    const scene::DrawReport a = draw({both[0]}, view, options).report,
                            b = draw({both[1]}, view, options).report, sum = draw(both, view, options).report;
    EXPECT_EQ(sum.counts.splats, a.counts.splats + b.counts.splats);
    EXPECT_EQ(sum.counts.nodes_visited, a.counts.nodes_visited + b.counts.nodes_visited);
    EXPECT_EQ(sum.counts.blocks_touched, a.counts.blocks_touched + b.counts.blocks_touched);
    EXPECT_EQ(sum.bytes_touched, a.bytes_touched + b.bytes_touched);
    EXPECT_EQ(sum.model_blocks, ball.header().block_count + torus.header().block_count);
    EXPECT_EQ(sum.counts.error_bound_px, std::max(a.counts.error_bound_px, b.counts.error_bound_px));
}

// The camera moved with the model sees the same.
TEST(SeveralModels, APlacedModelLooksAsFromAMovedCamera) {
    const splat::Model model = build_model(bumpy_torus(60, 160, true));
    const geom::Similarity placed = geom::parse_similarity("3,-2,5,0.25,30,-70,110", "test");
    geom::View view = view_of({{&model}});
    const Drawn here = draw({{&model}}, view);
    view.eye = placed.point(view.eye);
    view.right = placed.rotation * view.right, view.down = placed.rotation * view.down;
    view.forward = placed.rotation * view.forward;
    const Drawn there = draw({{&model, placed}}, view);
    EXPECT_GT(psnr_db(there, here), 60);
    for (size_t i = 0; i < here.frame.depth.size(); ++i) {
        if (!std::isfinite(here.frame.depth[i]) || !std::isfinite(there.frame.depth[i])) continue;
        EXPECT_NEAR(double(there.frame.depth[i]), 0.25 * double(here.frame.depth[i]), 0.02) << "world units";
    }
}

TEST(SeveralModels, AMirroredModelIsTheMirroredPicture) {
    const splat::Model model = build_model(bumpy_torus(60, 160, true));
    const geom::Similarity mirrored = geom::parse_similarity("-1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1", "test");
    geom::View view = view_of({{&model}});
    view.eye.x = 0, view.right = {1, 0, 0};
    view.forward.x = view.down.x = 0;
    const Drawn plain = draw({{&model}}, view), turned = draw({{&model, mirrored}}, view);
    Drawn flipped = plain;
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 320; ++x) {
            const size_t from = size_t(y * 320 + 319 - x), to = size_t(y * 320 + x);
            flipped.frame.depth[to] = plain.frame.depth[from];
            for (size_t c = 0; c < 3; ++c) flipped.frame.rgb[3 * to + c] = plain.frame.rgb[3 * from + c];
        }
    EXPECT_GT(psnr_db(turned, flipped), 45);
    EXPECT_LT(psnr_db(turned, plain), 35) << "the torus is not its own mirror image";
}

// Whether the 5x5 pixels about pixel i, of 320x240, are all nearer than `depth`.
bool is_inside(const render::Frame& frame, size_t i, float depth) {
    const int x = int(i % 320), y = int(i / 320);
    for (int v = std::max(y - 2, 0); v <= std::min(y + 2, 239); ++v)
        for (int u = std::max(x - 2, 0); u <= std::min(x + 2, 319); ++u)
            if (!(frame.depth[size_t(v) * 320 + size_t(u)] < depth)) return false;
    return true;
}

// Each is drawn in its own precision: a model a million times smaller, close to the eye, and one far away,
// whose cores show where the first one has nothing but covers, along its outline.
TEST(SeveralModels, OfVeryDifferentScalesAreDrawnAsAlone) {
    const splat::Model ball = build_model(icosphere(5));
    for (const double ratio : {1e-6, 1e-12}) {
        geom::Similarity small;
        small.scale = ratio, small.translation = {1e3, 0, 3 * ratio};
        geom::Camera camera;
        camera.eye = {1e3, 0, 7 * ratio}, camera.target = small.translation;
        // Both stand the same way in the picture: one behind the other.
        geom::Similarity large;
        large.scale = 1, large.translation = {1e3, 0, -2};
        const geom::View view = geom::make_view(camera, 320, 240);
        const Drawn alone = draw({{&ball, small}}, view), both = draw({{&ball, small}, {&ball, large}}, view);
        // But for a pixel here and there where splats of equal weight meet: units differ, and so does
        // rounding.
        size_t covered = 0, off = 0;
        for (size_t i = 0; i < alone.frame.depth.size(); ++i) {
            if (!is_inside(alone.frame, i, 10 * float(ratio))) continue;
            ++covered;
            off += !(std::abs(both.frame.depth[i] - alone.frame.depth[i]) <= 1e-5f * float(ratio));
        }
        EXPECT_LE(off, 5u);
        EXPECT_GT(covered, 1000u);
    }
}

TEST(SeveralModels, DrawTheSameFrameWithAnyNumberOfThreads) {
    const splat::Model ball = build_model(icosphere(5)), torus = build_model(bumpy_torus(60, 160, true));
    const std::vector<scene::PlacedModel> all{{&torus},
                                              {&ball, geom::parse_similarity("0,0.5,0,0.3", "test")},
                                              {&torus, geom::parse_similarity("0,0,1,2,90,0,0", "test")}};
    const geom::View view = view_of(all);
    core::set_thread_count(1);
    const Drawn one = draw(all, view);
    core::set_thread_count(16);
    const Drawn many = draw(all, view);
    core::set_thread_count(0);
    expect_same(one, many);
}

TEST(SeveralModels, HideEachOther) {
    const splat::Model ball = build_model(icosphere(6));
    const std::vector<scene::PlacedModel> nested{{&ball, geom::parse_similarity("0,0,0,0.5", "test")},
                                                 {&ball}};
    const geom::View view =
        geom::make_view(geom::orbit(scene::bounds_of(nested), {.frames = 1}).front(), 1280, 720);
    scene::DrawOptions off;
    off.occlusion = scene::Occlusion::off;
    const Drawn all = draw(nested, view, off), some = draw(nested, view);
    EXPECT_EQ(all.frame.rgb, some.frame.rgb);
    EXPECT_EQ(all.frame.depth, some.frame.depth);
    EXPECT_LT(double(some.report.counts.splats), 0.7 * double(all.report.counts.splats));
}

TEST(SeveralModels, AreBoundedTogether) {
    const splat::Model ball = build_model(icosphere(3));
    const double radius = ball.header().scale;
    const geom::Sphere all = scene::bounds_of(
        std::vector<scene::PlacedModel>{{&ball}, {&ball, geom::parse_similarity("10,0,0,2", "test")}});
    EXPECT_NEAR(all.radius, 0.5 * (10 + 3 * radius), 1e-6);
    EXPECT_NEAR(all.centre.x, ball.header().origin.x + 0.5 * (10 + radius), 1e-6);
}
