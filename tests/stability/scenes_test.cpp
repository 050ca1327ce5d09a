// Several models in one scene: of very different sizes, far away, and in each other.
#include <gtest/gtest.h>

#include <cmath>

#include "render/compare.h"
#include "subject.h"
#include "table.h"

namespace stability {
namespace {

struct Scene {
    const char* name;
    double scale;   // of a model that is placed
    glm::dvec3 at;  // in the world
};

std::ostream& operator<<(std::ostream& out, const Scene& scene) {
    return out << scene.name;
}

class Scenes : public testing::TestWithParam<Scene> {};

// Beside another of radius 1 at 0 that cannot be seen.
TEST_P(Scenes, PlaceAModelAsIfItStoodThereAlone) {
    const Scene& scene = GetParam();
    const Subject subject = build(bumpy_sphere(), Precision::single);
    geom::Camera camera;
    camera.eye = glm::dvec3(1.5, 2, 4.5);
    const Picture unit = draw(subject, camera, all_detail());

    geom::Similarity placed;
    placed.scale = scene.scale, placed.translation = scene.at;
    camera.target = scene.at, camera.eye = scene.at + scene.scale * camera.eye;
    const geom::View view = geom::make_view(camera, unit.view.width, unit.view.height);
    render::Frame frame, without;
    scene::ModelPainter painter({{subject.model.get()}, {subject.model.get(), placed}});
    scene::DrawOptions options = all_detail();
    options.occlusion = scene::Occlusion::on;
    const scene::DrawReport report = painter.draw(view, options, frame);
    options.occlusion = scene::Occlusion::off;
    painter.draw(view, options, without);

    expect_at_most(scene.name, "bad pixels", double(bad_pixels(frame)), 0);
    expect_at_most(scene.name, "holes against alone", double(render::compare(frame, unit.frame, 1).holes), 0);
    expect_at_least(scene.name, "psnr db against alone", render::compare(frame, unit.frame, 1).psnr_db, 45);
    expect_at_most(scene.name, "error bound px over alone", report.counts.error_bound_px,
                   1.01 * unit.report.counts.error_bound_px);
    expect_at_most(scene.name, "largest difference by occlusion",
                   render::compare(frame, without, 1).max_difference, 0);
}

// The other one is behind the eye, or too small or far away to be seen.
INSTANTIATE_TEST_SUITE_P(Table, Scenes,
                         testing::Values(Scene{"scene_small_1em6", 1e-6, {0, 0, -3}},
                                         Scene{"scene_small_1em9", 1e-9, {0, 0, -3}},
                                         Scene{"scene_large_1e6", 1e6, {0, 0, -1e7}},
                                         Scene{"scene_large_1e30", 1e30, {0, 0, -1e31}},
                                         Scene{"scene_far_1e6", 1, {1e6, -7e5, 4e5}},
                                         Scene{"scene_far_1e12", 1, {1e12, -7e11, 4e11}}),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace stability
