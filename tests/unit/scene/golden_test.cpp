// Pictures and depths of small models against those that are kept in tests/data/golden.
//
// The models are files as well, so that what is tested is drawing, and not building.
//
// Frames are the same bytes with any instruction set of a processor (splatter_test.cpp).  Between compilers
// and mathematical libraries last bits may differ: of a colour, which then is one level off, and of what
// decides whether a rim meets a pixel's centre or which of two splats is in front, which turns that pixel
// altogether, but seldom.  So a picture passes with one level everywhere and up to three such pixels, depths
// with some roundings of single precision and as many.
//
// tests/data/make-golden makes the files.  What a failed scene drew, and how it differs, is left in the
// folder `golden` beside the test program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>

#include "core/file.h"
#include "render/compare.h"
#include "render/image.h"
#include "scene/draw.h"

namespace {

using render::Shade;
using render::SplatKind;

const std::string kModels = QS_TEST_DATA "/";
const std::string kGolden = QS_TEST_DATA "/golden/";
const std::string kFailed = QS_GOLDEN_FAILED "/";

constexpr int kTurnedPixels = 3;
constexpr int kLevels = 1;
constexpr double kDepthRounding = 1e-5;  // relative: some roundings of single precision

struct Scene {
    const char* name;
    const char* model;
    geom::Camera camera;
    SplatKind kind = SplatKind::smooth;
    Shade shade = Shade::lit;
    double threshold_px = 0.5;
    glm::u8vec3 background{0, 0, 0};
};

void PrintTo(const Scene& scene, std::ostream* out) {
    *out << scene.name;
}

const geom::Camera kWhole{{1.2, 1.5, 4.2}, {0, 0, 0}};
const geom::Camera kFar{{14, 20, 60}, {0, 0, 0}};
// Just above the surface, so that splats reach behind the eye.
const geom::Camera kGrazing{{0, 0.2, 1.06}, {0.6, 0.1, 0.7}, {0, 0, 1}, 100};
const geom::Camera kBeside{{2.5, 3, 9}, {0, 0, 0}};
const geom::Camera kCutOpen{{1.2, 1.5, 4.2}, {0, 0, 0}, {0, 1, 0}, 30, 0, 4.2, 5.2};
// Inside of the model's one large splat.
const geom::Camera kInside{{1.8, 0.2, 0.1}, {-3, 0, 0}, {0, 1, 0}, 110};

const Scene kScenes[] = {
    {"bumpy-smooth-lit", "bumpy.qs", kWhole},
    {"bumpy-smooth-normal", "bumpy.qs", kWhole, SplatKind::smooth, Shade::normal},
    {"bumpy-smooth-level", "bumpy.qs", kWhole, SplatKind::smooth, Shade::level, 2},
    {"bumpy-smooth-flat", "bumpy.qs", kWhole, SplatKind::smooth, Shade::flat, 0.5, {20, 40, 60}},
    {"bumpy-ellipse-lit", "bumpy.qs", kWhole, SplatKind::ellipse},
    {"bumpy-ellipse-normal", "bumpy.qs", kWhole, SplatKind::ellipse, Shade::normal},
    {"bumpy-circle-level", "bumpy.qs", kWhole, SplatKind::circle, Shade::level, 2},
    {"bumpy-square-lit", "bumpy.qs", kWhole, SplatKind::square},
    {"bumpy-coarse-ellipse-lit", "bumpy.qs", kWhole, SplatKind::ellipse, Shade::lit, 20},
    {"bumpy-far-smooth-lit", "bumpy.qs", kFar, SplatKind::smooth, Shade::lit, 1},
    {"bumpy-grazing-smooth-lit", "bumpy.qs", kGrazing},
    {"bumpy-grazing-ellipse-lit", "bumpy.qs", kGrazing, SplatKind::ellipse},
    {"bumpy-cut-open-smooth-lit", "bumpy.qs", kCutOpen},
    {"bumpy-cut-open-square-normal", "bumpy.qs", kCutOpen, SplatKind::square, Shade::normal},
    {"cloud-smooth-lit", "cloud.qs", kWhole},
    {"cloud-circle-flat", "cloud.qs", kWhole, SplatKind::circle, Shade::flat},
    {"tiny-smooth-lit", "tiny.qs", kBeside},
    {"tiny-ellipse-flat", "tiny.qs", kBeside, SplatKind::ellipse, Shade::flat},
    {"tiny-inside-smooth-lit", "tiny.qs", kInside},
};

const Scene kDepthScenes[] = {
    {"bumpy-smooth", "bumpy.qs", kWhole},
    {"bumpy-grazing-ellipse", "bumpy.qs", kGrazing, SplatKind::ellipse},
    {"tiny-square", "tiny.qs", kBeside, SplatKind::square},
};

render::Frame draw(const Scene& scene, int width, int height) {
    const splat::Model model(kModels + scene.model);
    scene::DrawOptions options;
    options.cut.threshold_px = scene.threshold_px;
    options.kind = scene.kind;
    options.look.shade = scene.shade;
    options.look.background = scene.background;
    render::Frame frame;
    scene::ModelPainter(model).draw(geom::make_view(scene.camera, width, height), options, frame);
    return frame;
}

bool is_update() {
    return std::getenv("QS_UPDATE") != nullptr;
}

void write(const std::string& path, const std::vector<std::byte>& bytes) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    core::OutputFile file(path);
    file.write(bytes);
    file.commit();
}

void write(const std::string& path, const render::Image& image) {
    write(path, render::encode_png(image.rgb.data(), image.width, image.height));
}

// The depths of a PFM as encode_pfm() writes it.
std::vector<float> read_depths(const std::string& path, size_t count) {
    const core::InputFile file(path);
    std::vector<float> depths(count);
    EXPECT_GT(file.bytes().size(), count * sizeof(float));
    std::memcpy(depths.data(), file.bytes().last(count * sizeof(float)).data(), count * sizeof(float));
    return depths;
}

std::vector<float> upside_down(const std::vector<float>& rows, int width) {
    std::vector<float> turned;
    for (size_t end = rows.size(); end > 0; end -= size_t(width))
        turned.insert(turned.end(), rows.begin() + std::ptrdiff_t(end - size_t(width)),
                      rows.begin() + std::ptrdiff_t(end));
    return turned;
}

// Pixels of which a channel differs by more than kLevels.
int count_turned(const render::Image& a, const render::Image& b) {
    EXPECT_EQ(a.rgb.size(), b.rgb.size());
    int count = 0;
    for (size_t i = 0; i < std::min(a.rgb.size(), b.rgb.size()); i += 3) {
        int most = 0;
        for (size_t c = i; c < i + 3; ++c) most = std::max(most, std::abs(a.rgb[c] - b.rgb[c]));
        count += most > kLevels;
    }
    return count;
}

class GoldenPicture : public testing::TestWithParam<Scene> {};
class GoldenDepth : public testing::TestWithParam<Scene> {};

std::string test_name(const testing::TestParamInfo<Scene>& info) {
    std::string name = info.param.name;
    for (char& c : name)
        if (c == '-') c = '_';
    return name;
}

}  // namespace

TEST_P(GoldenPicture, IsDrawnAsItWas) {
    const Scene& scene = GetParam();
    const std::string file = kGolden + scene.name + ".png";
    render::Frame frame = draw(scene, 120, 90);
    const render::Image drawn{frame.width, frame.height, std::move(frame.rgb)};
    if (is_update()) return write(file, drawn);

    const render::Image golden = render::read_image(file);
    const int turned = count_turned(drawn, golden);
    if (turned <= kTurnedPixels) return;
    write(kFailed + scene.name + ".png", drawn);
    write(kFailed + scene.name + ".difference.png",
          render::difference_picture(drawn, golden, scene.background));
    const render::ImageDifference d = render::compare(drawn, golden, scene.background);
    ADD_FAILURE() << turned << " pixels differ by more than " << kLevels << ", by up to " << d.max_difference
                  << " (psnr " << d.psnr_db << " dB, worst at " << d.worst_x << ',' << d.worst_y
                  << "); what was drawn and the difference are in " << kFailed;
}

TEST_P(GoldenDepth, IsDrawnAsItWas) {
    const Scene& scene = GetParam();
    const std::string file = kGolden + scene.name + ".pfm";
    const render::Frame frame = draw(scene, 40, 30);
    const std::vector<std::byte> drawn = render::encode_pfm(frame.depth.data(), frame.width, frame.height);
    if (is_update()) return write(file, drawn);

    const std::vector<float> golden = upside_down(read_depths(file, frame.depth.size()), frame.width);
    int differ = 0;
    for (size_t i = 0; i < golden.size(); ++i) {
        const double a = double(frame.depth[i]), b = double(golden[i]);
        differ += std::isfinite(a) != std::isfinite(b) || std::abs(a - b) > kDepthRounding * b;
    }
    if (differ <= kTurnedPixels) return;
    write(kFailed + scene.name + ".pfm", drawn);
    ADD_FAILURE() << differ << " depths differ; what was drawn is in " << kFailed;
}

INSTANTIATE_TEST_SUITE_P(Scenes, GoldenPicture, testing::ValuesIn(kScenes), test_name);
INSTANTIATE_TEST_SUITE_P(Scenes, GoldenDepth, testing::ValuesIn(kDepthScenes), test_name);
