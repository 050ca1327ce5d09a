// Triangles and splats in one frame of OpenGL against those of render::Splatter.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <random>

#include "frames.h"
#include "gl/splat_painter.h"
#include "hybrid_scene.h"

namespace {

using gl_test::Difference;
using render::Frame;
using render::Shade;
using render::SplatKind;
using render::SplatterOptions;
using render_test::Scene;

// Corners that snap to the driver's grid move outlines across some pixels' centres.
constexpr double kLeastPsnrDb = 45, kMostTurned = 5e-4, kMostApart = 2e-4, kMostDepth = 1e-5;

Scene checkered(const mesh::Mesh& mesh, float cell) {
    Scene scene = render_test::hybrid_of(mesh, [&](const glm::vec3& p) {
        return (int(std::floor(p.x / cell)) + int(std::floor(p.y / cell))) % 2 != 0;
    });
    std::mt19937 random(2);
    for (render_test::Triangle& t : scene.triangles) t.colour = random() & 0xffffffu;
    for (render_test::Disc& d : scene.discs) d.colour = random() & 0xffffffu;
    return scene;
}

class Triangles : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        std::string reason;
        auto device = gl_test::open(GetParam(), reason);
        if (!device) GTEST_SKIP() << reason;
        painter_ = std::make_unique<gl::SplatPainter>(std::move(device));
    }

    void expect_agreement(const geom::View& view, const SplatterOptions& options, const Scene& scene) {
        SCOPED_TRACE(testing::Message()
                     << "kind " << int(options.kind) << " shade " << int(options.look.shade));
        const Frame expected = render_test::draw(view, options, scene);
        const Difference d =
            gl_test::difference(render_test::draw(*painter_, view, options, scene), expected);
        EXPECT_GE(d.psnr_db, kLeastPsnrDb) << d;
        // Which splats count where they blend depends on the order on the CPU.
        EXPECT_LE(d.turned, options.kind == SplatKind::smooth ? 2e-3 : kMostTurned) << d;
        EXPECT_LE(d.covered_apart, kMostApart) << d;
        EXPECT_LE(d.depth, kMostDepth) << d;
    }

    std::unique_ptr<gl::SplatPainter> painter_;
};

TEST_P(Triangles, AgreeOnEveryKindAndShade) {
    const Scene scene = checkered(render_test::ball(4, {0.2f, 0.1f, 3}, 1), 0.25f);
    const auto agree = [&](SplatKind kind, Shade shade, bool has_colour) {
        expect_agreement(render_test::view_of(400, 300, 350), {kind, {shade, {9, 8, 7}}, has_colour}, scene);
    };
    for (const SplatKind kind : {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth})
        agree(kind, Shade::lit, true);
    for (const Shade shade : {Shade::normal, Shade::level, Shade::flat})
        agree(SplatKind::ellipse, shade, true);
    for (const SplatKind kind : {SplatKind::ellipse, SplatKind::smooth}) agree(kind, Shade::lit, false);
}

TEST_P(Triangles, AgreeBetweenNearAndFarAndWithinAMesh) {
    const mesh::Mesh ball = render_test::ball(4, {0.2f, 0.1f, 3}, 1);
    geom::View view = render_test::view_of(400, 300, 350);
    view.near = 2.3, view.far = 3.1;
    expect_agreement(view, {SplatKind::ellipse, {Shade::normal}, false}, checkered(ball, 0.25f));
    const mesh::Mesh inside = render_test::seen_from(ball, {0.3, 0.2, 3.4}, {1, 0.2, -0.3});
    expect_agreement(render_test::view_of(200, 150, 60), {SplatKind::ellipse, {Shade::normal}, false},
                     checkered(inside, 0.25f));
}

TEST_P(Triangles, AgreeAlone) {
    Scene scene = checkered(render_test::ball(4, {0.2f, 0.1f, 3}, 1), 0.25f);
    scene.discs.clear();
    for (const SplatKind kind : {SplatKind::ellipse, SplatKind::smooth})
        expect_agreement(render_test::view_of(400, 300, 350), {kind, {Shade::lit, {9, 8, 7}}, true}, scene);
}

INSTANTIATE_TEST_SUITE_P(Contexts, Triangles, testing::ValuesIn(gl_test::kDrawingContexts),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
