// How pictures look: samples, backgrounds with an alpha, light, and pairs of eyes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "render/compare.h"
#include "render/raster.h"
#include "render/shading.h"
#include "scene/backends.h"
#include "scene/draw.h"
#include "scene/progressive.h"
#include "scene/reference.h"
#include "scene/shots.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

using render::Frame;
using render::SplatKind;

Frame drawn(const splat::Model& model, const geom::View& view, SplatKind kind, const render::Look& look,
            double threshold_px = 0.5) {
    scene::DrawOptions options;
    options.kind = kind, options.look = look, options.cut.threshold_px = threshold_px;
    Frame frame;
    scene::ModelPainter(model).draw(view, options, frame);
    return frame;
}

Frame drawn(const mesh::Mesh& mesh, const geom::View& view, const render::Look& look) {
    Frame frame;
    render::MeshRaster(mesh).draw(view, look, frame);
    return frame;
}

render::Look with_samples(int across) {
    render::Look look;
    look.background = {10, 20, 30};
    look.samples_across = across;
    return look;
}

double psnr_db(const Frame& a, const Frame& b) {
    return render::compare(a, b, 1).psnr_db;
}

// Each pixel the mean, to the nearest, of across x across ones.
std::vector<uint8_t> scaled_down(const Frame& large, int across) {
    const int width = large.width / across, height = large.height / across;
    std::vector<uint8_t> rgb;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) {
                int sum = across * across / 2;
                for (int sy = 0; sy < across; ++sy)
                    for (int sx = 0; sx < across; ++sx)
                        sum += large.rgb[size_t(3 * ((y * across + sy) * large.width + x * across + sx) + c)];
                rgb.push_back(uint8_t(sum / (across * across)));
            }
    return rgb;
}

void expect_mean_of(const Frame& large, int across, const Frame& frame) {
    EXPECT_EQ(frame.rgb, scaled_down(large, across));
    const int sample = across / 2;
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            ASSERT_EQ(frame.depth[size_t(y * frame.width + x)],
                      large.depth[size_t((y * across + sample) * large.width + x * across + sample)]);
}

}  // namespace

// A triangle that faces the eye, its longest side so many pixels long.
Frame drawn_by_size(double side_px) {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0.5f, 0}};
    mesh.triangles = {{0, 1, 2}};
    geom::Camera camera;
    camera.target = {0.2, 0.2, 0};
    camera.eye = {0.2, 0.2, 4};
    camera.fovy_deg = 30;
    geom::View view = geom::make_view(camera, 200, 200);
    view.focal_px = 4 * side_px / std::sqrt(1.25);
    const scene::Backend backend = scene::open_backend(scene::BackendKind::cpu);
    Frame frame;
    scene::draw_mesh(mesh, view, {render::Shade::level}, *backend.painter, frame);
    return frame;
}

TEST(ShadeLevel, ColoursTrianglesOfAMeshByTheirLongestSide) {
    for (const double side_px : {5.0, 30.0, 60.0, 150.0}) {
        const Frame frame = drawn_by_size(side_px);
        const glm::u8vec3 expected = render::level_colour(float(side_px));
        const size_t middle = 3 * (100 * 200 + 100);
        const glm::u8vec3 found(frame.rgb[middle], frame.rgb[middle + 1], frame.rgb[middle + 2]);
        EXPECT_EQ(found, expected) << side_px;
    }
}

TEST(Samples, AreThePixelsOfALargerPicture) {
    const mesh::Mesh mesh = bumpy_torus(60, 160, true);
    const splat::Model model = build_model(mesh);
    const geom::View view = fitted_view(model, 131, 77);
    for (const int across : {2, 4}) {
        const geom::View fine = geom::subdivided(view, across);
        const render::Look look = with_samples(across);
        expect_mean_of(drawn(mesh, fine, with_samples(1)), across, drawn(mesh, view, look));
        // These kinds have no cores; the threshold is in pixels, and not in samples.
        for (const SplatKind kind : {SplatKind::square, SplatKind::circle})
            expect_mean_of(drawn(model, fine, kind, with_samples(1), 0.5 * across), across,
                           drawn(model, view, kind, look));
    }
}

TEST(Samples, BringThePictureCloserToTheMeshOfManySamples) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    const geom::View view = fitted_view(model, 320, 240);
    const Frame truth = drawn(mesh, view, with_samples(4));
    for (const SplatKind kind : {SplatKind::ellipse, SplatKind::smooth}) {
        double last = 0;
        for (const int across : {1, 2, 4}) {
            const double psnr = psnr_db(drawn(model, view, kind, with_samples(across)), truth);
            EXPECT_GT(psnr, last + (across == 2 ? 2 : 0)) << int(kind) << ' ' << across;
            last = psnr;
        }
    }
}

// No sample within the mesh's silhouette is empty, however the cores lie, and a pixel all of whose samples
// are within it shows the background by half at most.
TEST(Samples, LeaveNoHole) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    render::Look look = with_samples(2);
    look.background_alpha = 0;
    for (const geom::View& view : random_views(model, mesh, 8))
        for (const SplatKind kind : {SplatKind::ellipse, SplatKind::smooth})
            for (const double threshold_px : {0.0, 1.0, 8.0}) {
                const Frame frame = drawn(model, view, kind, look, threshold_px);
                const Frame truth = drawn(mesh, view, look);
                int holes = 0, faint = 0;
                for (size_t i = 0; i < truth.depth.size(); ++i) {
                    holes += std::isfinite(truth.depth[i]) && !std::isfinite(frame.depth[i]);
                    faint += truth.alpha[i] == 255 && frame.alpha[i] < 127;
                }
                EXPECT_EQ(holes, 0) << int(kind) << ' ' << threshold_px;
                EXPECT_EQ(faint, 0) << int(kind) << ' ' << threshold_px;
            }
}

TEST(Samples, KeepTheMeasuredErrorWithinTheBound) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    scene::Reference reference(mesh, "torus", true);
    for (const geom::View& view : random_views(model, mesh, 6)) {
        scene::DrawOptions options;
        options.look.samples_across = 4;
        Frame frame;
        const scene::DrawReport report = scene::ModelPainter(model).draw(view, options, frame);
        const scene::ReferenceMeasures m = reference.measure(view, options.look, frame);
        EXPECT_LE(m.measured_error_px, report.counts.error_bound_px + 2e-3);
        EXPECT_EQ(m.difference.holes, 0u);
    }
}

// With a field of view as small as it is far away the model looks as from before it.
TEST(Samples, AreAsBrightFromVeryFarAway) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    geom::View view = fitted_view(model);
    const double distance = glm::dot(model.header().origin - view.eye, view.forward);
    const auto brightness = [&](double far) {
        geom::View moved = view;
        moved.eye -= (far - 1) * distance * view.forward, moved.focal_px *= far;
        scene::DrawOptions options;
        options.look.samples_across = 2;
        const Frame frame = draw({{&model}}, moved, options).frame;
        return std::accumulate(frame.rgb.begin(), frame.rgb.end(), 0.0);
    };
    for (const double far : {1e3, 1e5}) EXPECT_NEAR(brightness(far) / brightness(100), 1, 0.01) << far;
}

TEST(Alpha, IsThePartOfAPixelThatIsCovered) {
    const splat::Model model = build_model(icosphere(4));
    const geom::View view = fitted_view(model);
    render::Look look;
    look.background = {200, 100, 50};
    for (const int across : {1, 2, 4}) {
        look.samples_across = across;
        look.background_alpha = 255;
        const Frame opaque = drawn(model, view, SplatKind::smooth, look);
        EXPECT_TRUE(opaque.alpha.empty());
        look.background_alpha = 0;
        const Frame clear = drawn(model, view, SplatKind::smooth, look);
        look.background_alpha = 99;
        const Frame some = drawn(model, view, SplatKind::smooth, look);
        int between = 0;
        for (size_t i = 0; i < clear.alpha.size(); ++i) {
            const int covered = clear.alpha[i];
            between += covered > 0 && covered < 255;
            EXPECT_NEAR(some.alpha[i], covered + (255 - covered) * 99 / 255.0, 1);
            // Laid over a colour it is what was drawn over that colour.
            for (size_t c = 0; c < 3; ++c) {
                const double over =
                    (clear.rgb[3 * i + c] * covered + look.background[int(c)] * (255 - covered)) / 255.0;
                EXPECT_NEAR(opaque.rgb[3 * i + c], over, 1.51);
            }
        }
        EXPECT_EQ(between > 50, across > 1);
    }
}

TEST(KeyLight, LightsSplatsAndMeshAlike) {
    const mesh::Mesh mesh = bumpy_torus(60, 160);
    const splat::Model model = build_model(mesh);
    const geom::View view = fitted_view(model);
    render::Look look;
    look.key_light = glm::dvec3(-3, 2, 1);
    const Frame exact = drawn(mesh, view, look), head_lit = drawn(mesh, view, {});
    const double head = psnr_db(drawn(model, view, SplatKind::smooth, {}), head_lit);
    const Frame splats = drawn(model, view, SplatKind::smooth, look);
    EXPECT_GT(psnr_db(splats, exact), head - 1);
    EXPECT_LT(psnr_db(splats, head_lit), head - 6);
}

TEST(KeyLight, ShinesFromItsDirectionInTheWorld) {
    const mesh::Mesh mesh = icosphere(4);
    const geom::View view = fitted_view(build_model(mesh));
    render::Look look;
    look.key_light = -5.0 * view.forward;  // where the head light is
    EXPECT_LE(render::compare(drawn(mesh, view, look), drawn(mesh, view, {}), 1).max_difference, 1);
    look.key_light = view.right;
    const Frame frame = drawn(mesh, view, look);
    const auto grey = [&](double part) {
        return frame.rgb[3 * size_t(view.height / 2 * view.width + int(view.width * part))];
    };
    EXPECT_GT(grey(0.6), grey(0.4) + 30);
}

TEST(Stereo, KeepsTheTargetInPlaceAndMovesWhatIsNearer) {
    geom::Camera camera;
    camera.eye = {1, 2, 6}, camera.target = {0.5, 0, 0};
    scene::Screen screen;
    screen.width = 300, screen.height = 200, screen.is_stereo = true;
    const std::vector<scene::EyeView> eyes = scene::views_of(camera, screen);
    ASSERT_EQ(eyes.size(), 2u);
    EXPECT_EQ(eyes[0].eye, "left");
    const auto place = [](const geom::View& view, const glm::dvec3& point) {
        const glm::dvec3 p = view.view_from_world(point);
        return view.principal() + view.focal_px * glm::dvec2(p) / p.z;
    };
    const auto parallax = [&](const glm::dvec3& point) {
        return place(eyes[0].view, point) - place(eyes[1].view, point);
    };
    const glm::dvec3 towards_eye = camera.eye - camera.target;
    EXPECT_NEAR(glm::length(parallax(camera.target)), 0, 1e-9);
    EXPECT_NEAR(glm::length(place(eyes[0].view, camera.target) - glm::dvec2(150, 100)), 0, 1e-9);
    EXPECT_GT(parallax(camera.target + 0.3 * towards_eye).x, 1);  // crossed: it comes out of the screen
    EXPECT_LT(parallax(camera.target - 0.3 * towards_eye).x, -1);
    EXPECT_NEAR(parallax(camera.target + 0.3 * towards_eye).y, 0, 1e-9);
    const double apart = glm::length(eyes[0].view.eye - eyes[1].view.eye);
    EXPECT_NEAR(apart / glm::length(towards_eye), 2 * std::tan(std::numbers::pi / 180), 1e-12);
}

TEST(Tiles, TakeEachPixelOnce) {
    for (const auto& [width, height, across, down] :
         {std::array{101, 67, 4, 3}, std::array{5, 5, 5, 5}, std::array{32768, 32768, 2, 3}}) {
        const geom::View view = geom::make_view({}, width, height);
        int left = 0, top = 0;
        for (int x = 0; x < across; ++x) {
            const geom::View tile = scene::tile_of(view, {x, 0, across, down});
            EXPECT_EQ(tile.margins.left, left);
            left += tile.width;
        }
        for (int y = 0; y < down; ++y) {
            const geom::View tile = scene::tile_of(view, {0, y, across, down});
            EXPECT_EQ(tile.margins.top, top);
            top += tile.height;
        }
        EXPECT_EQ(left, width);
        EXPECT_EQ(top, height);
    }
}
