// Explanations: that each part is said to be used where it is, and left out where it is not.
#include "scene/explain.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

scene::Explanation explain(const splat::Model& model, const geom::View& view,
                           const scene::DrawOptions& options = {}) {
    scene::ModelPainter painter(model);
    return scene::explain(painter, view, options);
}

scene::Part part(const scene::Explanation& explanation, const std::string& name) {
    const auto found = std::find_if(explanation.parts.begin(), explanation.parts.end(),
                                    [&](const scene::Part& p) { return p.name == name; });
    return found == explanation.parts.end() ? scene::Part{"(missing)", false, ""} : *found;
}

}  // namespace

TEST(Explanation, OfColour) {
    const splat::Model grey = build_model(bumpy_torus(20, 40));
    const splat::Model coloured = build_model(bumpy_torus(20, 40, true));
    mesh::Mesh mesh = bumpy_torus(20, 40, true);
    std::fill(mesh.colours.begin(), mesh.colours.end(), mesh.colours.front());
    const splat::Model constant = build_model(mesh);
    EXPECT_FALSE(part(explain(grey, fitted_view(grey)), "colour channel").is_used);
    EXPECT_TRUE(part(explain(coloured, fitted_view(coloured)), "colour channel").is_used);
    EXPECT_EQ(part(explain(constant, fitted_view(constant)), "colour channel").why,
              "one colour for all is in the header");
    scene::DrawOptions options;
    options.look.shade = render::Shade::normal;
    EXPECT_FALSE(part(explain(coloured, fitted_view(coloured), options), "colours in shading").is_used);
}

TEST(Explanation, OfTheBackfaceTest) {
    const splat::Model closed = build_model(bumpy_torus(20, 40)), open = build_model(terrain(20));
    const geom::View view = fitted_view(closed);
    const scene::Explanation plain = explain(closed, view);
    EXPECT_TRUE(part(plain, "backface test").is_used);
    EXPECT_GT(plain.frame.draw.counts.backface_culled, 0u);
    EXPECT_EQ(part(explain(open, fitted_view(open)), "backface test").why,
              "the surface is open, and both its sides may be seen");
    scene::DrawOptions options;
    options.cut.cull_backfaces = false;
    EXPECT_EQ(part(explain(closed, view, options), "backface test").why, "--keep-backfaces was given");
    geom::View cut = view;
    cut.near = glm::length(view.eye - closed.header().origin);
    EXPECT_FALSE(part(explain(closed, cut), "backface test").is_used);
    EXPECT_TRUE(part(explain(closed, cut), "near and far").is_used);
}

TEST(Explanation, OfTheFrustumTestWhichEndsWhereAllIsInside) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    geom::View wide = fitted_view(model);
    wide.focal_px *= 0.5;
    const splat::CutCounts whole = explain(model, wide).frame.draw.counts;
    EXPECT_EQ(whole.side_test_level, 1u);
    EXPECT_LE(whole.side_tests, 7u);
    for (const geom::View& view : close_views(model, mesh, 5)) {
        const splat::CutCounts close = explain(model, view).frame.draw.counts;
        EXPECT_GT(close.side_test_level, 1u);
        EXPECT_LE(close.side_test_level, model.header().level_count);
        EXPECT_LE(close.side_tests, close.nodes_visited);
    }
}

TEST(Explanation, OfAPrefix) {
    Bytes bytes = build_bytes(bumpy_torus(60, 160));
    bytes.resize(bytes.size() / 2);
    const splat::Model model = open_model(bytes);
    EXPECT_TRUE(part(explain(model, fitted_view(model)), "test for missing blocks").is_used);
}

TEST(Explanation, OfShading) {
    const splat::Model model = build_model(bumpy_torus(20, 40));
    scene::DrawOptions options;
    options.look.shade = render::Shade::flat;
    options.kind = render::SplatKind::circle;
    const scene::Explanation explanation = explain(model, fitted_view(model), options);
    EXPECT_FALSE(part(explanation, "normals in shading").is_used);
    EXPECT_FALSE(part(explanation, "blending").is_used);
    EXPECT_FALSE(part(explanation, "error bound").is_used);
    const scene::Explanation plain = explain(model, fitted_view(model));
    for (const char* name : {"normals in shading", "blending", "error bound"})
        EXPECT_TRUE(part(plain, name).is_used) << name;
}

TEST(Explanation, IsTheReportOfTheFrameWithoutItsTimes) {
    const splat::Model model = build_model(bumpy_torus(20, 40));
    const scene::Explanation explanation = explain(model, fitted_view(model));
    core::Json json = scene::to_json(explanation);
    EXPECT_EQ(json["parts"].size(), explanation.parts.size());
    json.erase("parts");
    core::Json report = scene::to_json(explanation.frame);
    report.erase("ms");
    EXPECT_EQ(json, report);
}
