// Parts of pictures: put together they are the whole, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>

#include "render/raster.h"
#include "scene/draw.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

using render::SplatKind;

constexpr SplatKind kKinds[] = {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth};

// Cuts that are no multiples of anything.
constexpr int kColumns[] = {0, 1, 70, 101}, kRows[] = {0, 37, 64};

// The picture that `draw` makes of the parts.
template <class Draw>
render::Frame put_together(const geom::View& view, const Draw& draw) {
    render::Frame all;
    all.resize(view.width, view.height);
    for (size_t row = 0; row < std::size(kRows); ++row)
        for (size_t column = 0; column < std::size(kColumns); ++column) {
            const int left = kColumns[column], top = kRows[row];
            const int right = column + 1 < std::size(kColumns) ? kColumns[column + 1] : view.width;
            const int bottom = row + 1 < std::size(kRows) ? kRows[row + 1] : view.height;
            render::Frame part;
            draw(geom::part_of(view, left, top, right - left, bottom - top), part);
            EXPECT_EQ(part.width, right - left);
            EXPECT_EQ(part.height, bottom - top);
            for (int y = 0; y < part.height; ++y) {
                const auto from = std::ptrdiff_t(y) * part.width,
                           to = std::ptrdiff_t(top + y) * view.width + left;
                std::copy_n(part.rgb.begin() + 3 * from, 3 * part.width, all.rgb.begin() + 3 * to);
                std::copy_n(part.depth.begin() + from, part.width, all.depth.begin() + to);
            }
        }
    return all;
}

void expect_parts_of_the_whole(const splat::Model& model, const geom::View& view,
                               const scene::DrawOptions& options) {
    scene::ModelPainter painter(model);
    render::Frame whole;
    painter.draw(view, options, whole);
    const render::Frame parts = put_together(
        view, [&](const geom::View& part, render::Frame& frame) { painter.draw(part, options, frame); });
    EXPECT_EQ(whole.rgb, parts.rgb);
    EXPECT_EQ(whole.depth, parts.depth);
}

}  // namespace

TEST(PartsOfAPicture, AreThoseOfTheWholeForAllKindsOfSplats) {
    const mesh::Mesh mesh = bumpy_torus(60, 160, true);
    const splat::Model model = build_model(mesh);
    std::vector<geom::View> views = random_views(model, mesh, 5);
    views.push_back(fitted_view(model));
    for (const geom::View& view : views)
        for (const SplatKind kind : kKinds)
            for (const double threshold_px : {0.5, 8.0}) {
                scene::DrawOptions options;
                options.kind = kind;
                options.cut.threshold_px = threshold_px;
                expect_parts_of_the_whole(model, view, options);
            }
}

TEST(PartsOfAPicture, AreThoseOfTheWholeWhereSplatsReachBehindTheEye) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    for (geom::View view : close_views(model, mesh, 5)) {
        for (const SplatKind kind : kKinds) {
            scene::DrawOptions options;
            options.kind = kind;
            options.cut.threshold_px = 20;
            expect_parts_of_the_whole(model, view, options);
        }
        view.near = 0.05 * model.header().scale;
        expect_parts_of_the_whole(model, view, {});
    }
}

TEST(PartsOfAPicture, AreThoseOfTheWholeOffTheAxis) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    for (const double shift_px : {-33.37, 0.1, 250.0}) {
        geom::View view = fitted_view(model);
        view.shift_px = {shift_px, 7.77};
        expect_parts_of_the_whole(model, view, {});
    }
}

TEST(PartsOfAPicture, AreThoseOfTheWholeForTheMesh) {
    const mesh::Mesh mesh = bumpy_torus(60, 160, true);
    const splat::Model model = build_model(mesh);
    std::vector<geom::View> views = close_views(model, mesh, 3);
    views.push_back(fitted_view(model));
    views.back().shift_px = {0.3, -11};
    views.push_back(fitted_view(model));
    render::MeshRaster raster(mesh);
    for (const geom::View& view : views) {
        const auto draw = [&](const geom::View& part, render::Frame& frame) {
            raster.draw(part, {render::Shade::lit, {1, 2, 3}}, frame);
        };
        render::Frame whole;
        draw(view, whole);
        const render::Frame parts = put_together(view, draw);
        EXPECT_EQ(whole.rgb, parts.rgb);
        EXPECT_EQ(whole.depth, parts.depth);
    }
}

// A part of a picture costs a part of the walk.
TEST(PartsOfAPicture, AreCutToThePart) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    const geom::View view = fitted_view(model, 640, 480);
    scene::DrawOptions options;
    options.cut.threshold_px = 0.2;
    render::Frame frame;
    scene::ModelPainter painter(model);
    const uint64_t whole = painter.draw(view, options, frame).counts.splats;
    const uint64_t part = painter.draw(geom::part_of(view, 300, 200, 64, 48), options, frame).counts.splats;
    EXPECT_LT(part, whole / 8);
}

// The shift moves the picture, and nothing else: a picture cut out of a wider one.
TEST(AShiftedView, IsAPartOfAWiderPicture) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    const geom::View wide = fitted_view(model, 200, 120);
    geom::View shifted = wide;
    shifted.width = 160, shifted.shift_px.x = 20;  // its left 160 columns: the middle is at 100, not at 80
    scene::DrawOptions options;
    options.kind = SplatKind::ellipse;  // free of the order, which the wider picture has its own of
    options.cut.threshold_px = 0;       // and of the corners, which the nearest depths are found by
    render::Frame part, off_axis;
    scene::ModelPainter painter(model);
    painter.draw(geom::part_of(wide, 0, 0, 160, 120), options, part);
    painter.draw(shifted, options, off_axis);
    EXPECT_EQ(part.rgb, off_axis.rgb);
    EXPECT_EQ(part.depth, off_axis.depth);
}
