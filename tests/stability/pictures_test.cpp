// Pictures of extreme sizes, and splats of extreme sizes in them, of a surface of radius 1.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/error.h"
#include "scene/shots.h"
#include "subject.h"
#include "table.h"

namespace stability {
namespace {

const Subject& unit_model() {
    static const Subject subject = build(bumpy_sphere(), Precision::single);
    return subject;
}

geom::View look(const glm::dvec3& eye, const glm::dvec3& target, double fovy_deg, int width, int height) {
    geom::Camera camera;
    camera.eye = eye, camera.target = target, camera.fovy_deg = fovy_deg;
    return geom::make_view(camera, width, height);
}

struct Case {
    const char* name;
    std::function<geom::View()> view;
    double threshold_px;
    uint64_t least_covered;
    bool is_before_all;  // the whole model is before the eye
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
    return out << c.name;
}

constexpr double kRootOnly = 1e6;

const Case kCases[] = {
    {"1x1",
     [] {
         return look({0, 0, 5}, {0, 0, 0}, 30, 1, 1);
     },
     0, 1, true},
    {"1x16384",
     [] {
         return look({0, 0, 5}, {0, 0, 0}, 30, 1, 16384);
     },
     0, 1, true},
    {"16384x1",
     [] {
         return look({0, 0, 5}, {0, 0, 0}, 1, 16384, 1);
     },
     0, 1, true},
    // 160 x 160 pixels: of the middle, where the surface's outline is, and of the last corner.
    {"32768x32768_middle",
     [] {
         return geom::part_of(look({0, 0, 5}, {0, 0, 0}, 30, 32768, 32768), 16300, 16300, 160, 160);
     },
     0, 160 * 160, true},
    {"32768x32768_outline",
     [] {
         return geom::part_of(look({0, 0, 5}, {0, 0, 0}, 30, 32768, 32768), 16300, 4040, 160, 160);
     },
     0, 0, true},
    {"32768x32768_corner",
     [] {
         return scene::tile_of(look({0, 0, 2}, {0.5, -0.5, 0}, 20, 32768, 32768), {255, 255, 256, 256});
     },
     0, 0, true},
    {"splat_larger_than_screen",
     [] {
         return look({0, 0, 3}, {0.1, 0.2, 0}, 5, 200, 150);
     },
     kRootOnly, 200 * 150, true},
    {"splat_larger_than_32768x32768",
     [] {
         return geom::part_of(look({0, 0, 3}, {0.1, 0.2, 0}, 5, 32768, 32768), 0, 32600, 160, 160);
     },
     kRootOnly, 160 * 160, true},
    {"near_through_large_spheres",
     [] {
         geom::View view = look({0, 0, 1.8}, {0, 0, 0}, 90, 200, 150);
         view.near = 1.5;
         return view;
     },
     kRootOnly, 1, false},
    {"eye_plane_through_large_spheres",
     [] {
         return look({0, 0, 0.3}, {0, 0.2, -1}, 120, 200, 150);
     },
     500, 200 * 150, false},
};

class Pictures : public testing::TestWithParam<Case> {};

TEST_P(Pictures, HoldWhatIsPromised) {
    const Case& c = GetParam();
    const Subject& subject = unit_model();
    for (const int across : {1, 2})
        for (const render::SplatKind kind : {render::SplatKind::square, render::SplatKind::circle,
                                             render::SplatKind::ellipse, render::SplatKind::smooth}) {
            const bool is_bounded = kind == render::SplatKind::ellipse || kind == render::SplatKind::smooth;
            const std::string row = core::text("%s %d of %d x %d samples", c.name, int(kind), across, across);
            scene::DrawOptions options = all_detail();
            options.kind = kind;
            options.cut.threshold_px = c.threshold_px;
            options.cut.cull_backfaces = c.is_before_all;
            options.look.samples_across = across;
            Picture picture;
            picture.view = c.view();
            picture.report = scene::ModelPainter(*subject.model).draw(picture.view, options, picture.frame);
            expect_at_most(row, "bad pixels", double(bad_pixels(picture.frame)), 0);
            if (!is_bounded) continue;
            expect_at_least(row, "covered pixels", double(covered_pixels(picture.frame)),
                            double(c.least_covered));
            expect_at_most(row, "error px", measured_error_px(subject, picture),
                           picture.report.counts.error_bound_px + measurement_rounding_px(picture));
            if (across == 1)
                expect_at_most(row, "holes", double(difference_from_mesh(subject, picture).holes), 0);
        }
}

INSTANTIATE_TEST_SUITE_P(Table, Pictures, testing::ValuesIn(kCases), testing::PrintToStringParamName());

}  // namespace
}  // namespace stability
