// Frames of OpenGL against those of render::Splatter, for every kind of splat, shade and awkward camera.
#include "gl/splat_painter.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/parallel.h"
#include "frames.h"
#include "render/splatter.h"
#include "scene/draw.h"
#include "test_meshes.h"
#include "two_pass.h"

namespace {

using gl_test::Difference;
using gl_test::Splats;
using render::Frame;
using render::Shade;
using render::SplatKind;

constexpr SplatKind kKinds[] = {SplatKind::square, SplatKind::circle, SplatKind::ellipse, SplatKind::smooth};
constexpr const char* kKindNames[] = {"square", "circle", "ellipse", "smooth"};

// Of two frames that differ by rounding: rims that meet a pixel's centre but for it, and splats of the same
// depth.
constexpr double kLeastPsnrDb = 55, kMostTurned = 1e-3, kMostApart = 1e-4, kMostDepth = 1e-4;

// One painter for all tests of a context: to link the shaders takes longer than to draw.
struct Painter {
    std::shared_ptr<gl::SplatPainter> painter;
    std::string reason;
};

const Painter& painter_of(const std::string& context) {
    static std::map<std::string, Painter> painters;
    const auto [at, is_new] = painters.try_emplace(context);
    if (is_new)
        if (auto device = gl_test::open(context, at->second.reason))
            at->second.painter = std::make_shared<gl::SplatPainter>(std::move(device));
    return at->second;
}

// Keeps what it is given.
class Recorder final : public render::SplatPainter {
  public:
    explicit Recorder(Splats& splats) : splats_(splats) {}
    void begin(const geom::View& view, const render::SplatterOptions& options, size_t tasks) override {
        splats_ = {view, options, std::vector<std::vector<render::SplatBatch>>(tasks)};
    }
    void add(size_t task, const render::SplatBatch& batch) override { splats_.tasks[task].push_back(batch); }
    void add(size_t, const render::TriangleBatch&) override { ADD_FAILURE() << "a triangle of points"; }
    void end_task(size_t) override {}
    void finish(Frame&) override {}

  private:
    Splats& splats_;
};

Splats splats_of(const splat::Model& model, const geom::View& view, const scene::DrawOptions& options) {
    Splats splats;
    Frame none;
    scene::ModelPainter(model, std::make_unique<Recorder>(splats)).draw(view, options, none);
    return splats;
}

Frame draw(render::SplatPainter& painter, const Splats& splats) {
    Frame frame;
    painter.begin(splats.view, splats.options, splats.tasks.size());
    core::parallel_for(splats.tasks.size(), [&](size_t task) {
        for (const render::SplatBatch& batch : splats.tasks[task]) painter.add(task, batch);
        painter.end_task(task);
    });
    painter.finish(frame);
    return frame;
}

Frame draw_on_cpu(const Splats& splats) {
    render::Splatter splatter;
    return draw(splatter, splats);
}

// The same splats, the last one first.
Splats reversed(Splats splats) {
    std::reverse(splats.tasks.begin(), splats.tasks.end());
    for (std::vector<render::SplatBatch>& task : splats.tasks) {
        std::reverse(task.begin(), task.end());
        for (render::SplatBatch& b : task) {
            for (float* values : {b.x, b.y, b.z, b.radius, b.nx, b.ny, b.nz, b.flatness})
                std::reverse(values, values + b.count);
            std::reverse(b.colour, b.colour + b.count);
        }
    }
    return splats;
}

class SplatPainter : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        const Painter& found = painter_of(GetParam());
        if (!found.painter) GTEST_SKIP() << found.reason;
        painter_ = found.painter;
    }

    // But for rounding with the CPU's, or, where that depends on the order of the splats, with what is
    // promised.
    void expect_agreement(const Splats& splats) {
        SCOPED_TRACE(kKindNames[int(splats.options.kind)]);
        const bool is_smooth = splats.options.kind == SplatKind::smooth;
        const Frame expected = is_smooth ? gl_test::draw_in_two_passes(splats) : draw_on_cpu(splats);
        const Difference d = gl_test::difference(draw(*painter_, splats), expected);
        EXPECT_GE(d.psnr_db, kLeastPsnrDb) << d;
        EXPECT_LE(d.turned, kMostTurned) << d;
        EXPECT_LE(d.covered_apart, kMostApart) << d;
        EXPECT_LE(d.depth, kMostDepth) << d;
    }

    std::shared_ptr<gl::SplatPainter> painter_;
};

const geom::Camera kWhole{{1.2, 1.5, 4.2}, {0, 0, 0}};
const geom::Camera kFar{{14, 20, 60}, {0, 0, 0}};
// Just above the surface, so that splats reach behind the eye.
const geom::Camera kGrazing{{0, 0.2, 1.06}, {0.6, 0.1, 0.7}, {0, 0, 1}, 100};
const geom::Camera kInside{{0.1, 0.2, 0.3}, {1, 0.4, 0}, {0, 1, 0}, 90};

geom::View view_of(const geom::Camera& camera, int width = 400, int height = 300) {
    return geom::make_view(camera, width, height);
}

splat::Model test_model(const std::string& file) {
    return splat::Model(QS_TEST_DATA "/" + file);
}

}  // namespace

TEST_P(SplatPainter, AgreesOnEveryKindAndShade) {
    const splat::Model coloured = splat_test::build_model(splat_test::bumpy_torus(60, 160, true));
    const splat::Model grey = test_model("bumpy.qs");
    for (const splat::Model* model : {&coloured, &grey})
        for (const SplatKind kind : kKinds)
            for (const Shade shade : {Shade::lit, Shade::normal, Shade::level, Shade::flat}) {
                SCOPED_TRACE(int(shade));
                scene::DrawOptions options;
                options.kind = kind, options.look.shade = shade, options.look.background = {20, 40, 60};
                options.cut.threshold_px = 1;
                expect_agreement(splats_of(*model, view_of(kWhole), options));
            }
}

TEST_P(SplatPainter, AgreesWhereverTheCameraIs) {
    for (const char* file : {"bumpy.qs", "cloud.qs", "tiny.qs"})
        for (const geom::Camera& camera : {kWhole, kFar, kGrazing, kInside})
            for (const double threshold_px : {0.5, 20.0})
                for (const SplatKind kind : kKinds) {
                    SCOPED_TRACE(file);
                    SCOPED_TRACE(camera.eye.x);
                    scene::DrawOptions options;
                    options.kind = kind;
                    options.cut.threshold_px = threshold_px;
                    options.cut.cull_backfaces = false;
                    expect_agreement(splats_of(test_model(file), view_of(camera), options));
                }
}

TEST_P(SplatPainter, AgreesBetweenNearAndFar) {
    geom::Camera camera = kWhole;
    camera.near = 4.2, camera.far = 5.2;
    for (const SplatKind kind : kKinds) {
        scene::DrawOptions options;
        options.kind = kind;
        expect_agreement(splats_of(test_model("bumpy.qs"), view_of(camera), options));
    }
}

TEST_P(SplatPainter, AgreesOnPicturesThatAreDrawnInParts) {
    for (const SplatKind kind : kKinds)
        for (const auto& [width, height] : {std::pair(1, 1), std::pair(4500, 64), std::pair(48, 4200)}) {
            scene::DrawOptions options;
            options.kind = kind;
            expect_agreement(splats_of(test_model("bumpy.qs"), view_of(kWhole, width, height), options));
        }
}

TEST_P(SplatPainter, DrawsPartsAsTheyAreInTheWhole) {
    const splat::Model model = test_model("bumpy.qs");
    geom::View view = view_of(kGrazing);
    view.shift_px = {30.25, -17};
    const geom::View part = geom::part_of(view, 101, 67, 150, 90);
    for (const SplatKind kind : kKinds) {
        scene::DrawOptions options;
        options.kind = kind;
        const Splats of_part = splats_of(model, part, options);
        expect_agreement(of_part);
        const Frame whole = draw(*painter_, splats_of(model, view, options)),
                    drawn = draw(*painter_, of_part);
        for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x) {
                const size_t at = size_t(y * part.width + x),
                             in_whole = size_t((y + 67) * view.width + x + 101);
                ASSERT_EQ(drawn.depth[at], whole.depth[in_whole]) << x << ',' << y;
                ASSERT_EQ(drawn.rgb[3 * at], whole.rgb[3 * in_whole]) << x << ',' << y;
            }
    }
}

// Splats of all sizes and attitudes, in view and out of it, before the eye, at it and behind it.
TEST_P(SplatPainter, AgreesOnSplatsOfAnySizeAndPlace) {
    splat_test::Random random(5);
    for (const double unit : {1.0, 1e-25, 1e25})
        for (const SplatKind kind : kKinds) {
            SCOPED_TRACE(unit);
            const geom::View view = view_of({{0, 0, 0}, {0, 0, 1}, {0, -1, 0}, 60});
            Splats splats{view, {kind, {}, true, 1}, {{}, {{}}}};
            render::SplatBatch& batch = splats.tasks[1][0];
            for (size_t i = 0; i < 300; ++i) {
                const glm::dvec3 at = unit * std::pow(10.0, 2 * random.unit()) * random.direction();
                const glm::dvec3 normal = random.direction();
                batch.x[i] = float(at.x), batch.y[i] = float(at.y), batch.z[i] = float(at.z);
                batch.nx[i] = float(normal.x), batch.ny[i] = float(normal.y), batch.nz[i] = float(normal.z);
                batch.radius[i] = float(glm::length(at) * 0.3 * std::pow(1e-3, random.unit()));
                batch.flatness[i] = float(std::pow(0.01, random.unit()));
                batch.colour[i] = uint32_t(random.bits() & 0xffffff);
                ++batch.count;
            }
            expect_agreement(splats);
        }
}

// The CPU blends in the order of the splats, so that its own frames differ as much: most where a picture is
// small and its splats are many pixels wide, which are folds and rims then wherever one looks.
TEST_P(SplatPainter, IsAsNearToTheCpuAsThatIsToItselfInAnotherOrder) {
    const splat::Model torus = splat_test::build_model(splat_test::bumpy_torus(60, 160, true));
    const splat::Model bumpy = test_model("bumpy.qs");
    for (const splat::Model* model : {&torus, &bumpy})
        for (const geom::Camera& camera : {kWhole, kFar})
            for (const auto& [width, height, threshold_px] :
                 {std::tuple(400, 300, 0.5), std::tuple(400, 300, 2.0), std::tuple(64, 48, 1.0),
                  std::tuple(64, 48, 4.0)}) {
                SCOPED_TRACE(width);
                scene::DrawOptions options;
                options.cut.threshold_px = threshold_px;
                const Splats splats = splats_of(*model, view_of(camera, width, height), options);
                const Frame cpu = draw_on_cpu(splats), drawn = draw(*painter_, splats);
                const Difference other = gl_test::difference(draw_on_cpu(reversed(splats)), cpu);
                const Difference d = gl_test::difference(drawn, cpu);
                // Up to twice the squared error: few pixels make it.
                EXPECT_GE(d.psnr_db, other.psnr_db - 3) << d << "; " << other;
                EXPECT_LE(d.covered_apart, kMostApart) << d;
            }
}

TEST_P(SplatPainter, DrawsTheBackgroundWhereThereAreNoSplats) {
    for (const SplatKind kind : kKinds) {
        Frame frame;
        painter_->begin(view_of(kWhole, 7, 5), {kind, {Shade::lit, {1, 2, 3}}, false, 1}, 3);
        painter_->finish(frame);
        ASSERT_EQ(frame.depth.size(), 35u);
        for (size_t i = 0; i < 35; ++i) {
            EXPECT_TRUE(std::isinf(frame.depth[i]));
            EXPECT_EQ(frame.rgb[3 * i + 2], 3);
        }
    }
}

TEST_P(SplatPainter, DrawsTheSameFrameWithAnyNumberOfThreadsAndAfterAnyOther) {
    const splat::Model model = splat_test::build_model(splat_test::bumpy_torus(60, 160, true));
    for (const SplatKind kind : kKinds) {
        scene::DrawOptions options;
        options.kind = kind;
        const Splats splats = splats_of(model, view_of(kWhole), options);
        const Splats others = splats_of(model, view_of(kGrazing, 650, 120), options);
        Frame first;
        for (const int threads : {1, 2, 7}) {
            core::set_thread_count(threads);
            const Frame frame = draw(*painter_, splats);
            if (first.rgb.empty()) first = frame;
            EXPECT_EQ(first.rgb, frame.rgb);
            EXPECT_EQ(first.depth, frame.depth);
            draw(*painter_, others);
        }
    }
    core::set_thread_count(0);
}

INSTANTIATE_TEST_SUITE_P(Contexts, SplatPainter, testing::ValuesIn(gl_test::kDrawingContexts));
