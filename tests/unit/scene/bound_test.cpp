// The promises of a frame, as drawn: no pixel is further from the surface than the report says, and there is
// no hole in it, at any threshold, from anywhere, and from any prefix of a model.
#include <gtest/gtest.h>

#include <cmath>

#include "scene/draw.h"
#include "scene/reference.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

constexpr double kThresholds[] = {0, 0.5, 1, 2, 4, 8};

// What frame-report(5) allows for rounding.
double rounding_px(const geom::View& view) {
    return 2e-3 + 1e-6 * view.height;
}

struct Case {
    std::string name;
    mesh::Mesh mesh;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
    return out << c.name;
}

std::string describe(const geom::View& view) {
    return "eye " + std::to_string(view.eye.x) + " " + std::to_string(view.eye.y) + " " +
           std::to_string(view.eye.z) + ", towards " + std::to_string(view.forward.x) + " " +
           std::to_string(view.forward.y) + " " + std::to_string(view.forward.z) + ", focal length " +
           std::to_string(view.focal_px) + " px";
}

// A model, its mesh, and a painter.
class Subject {
  public:
    Subject(const Case& c, Bytes bytes)
        : model_(open_model(bytes)), painter_(model_), reference_(c.mesh, c.name, true) {}

    const splat::Model& model() const { return model_; }

    void expect_kept_promises(const geom::View& view, double threshold_px, render::SplatKind kind) {
        scene::DrawOptions options;
        options.cut.threshold_px = threshold_px;
        options.kind = kind;
        render::Frame frame;
        const scene::DrawReport report = painter_.draw(view, options, frame);
        const scene::ReferenceMeasures measures = reference_.measure(view, options.look, frame);
        EXPECT_EQ(measures.difference.holes, 0u)
            << describe(view) << ", threshold " << threshold_px << ", kind " << int(kind);
        EXPECT_LE(measures.measured_error_px, report.counts.error_bound_px + rounding_px(view))
            << describe(view) << ", threshold " << threshold_px << ", kind " << int(kind);
        for (const float depth : reference_.frame().depth) seen_ += std::isfinite(depth);
        has_finite_bound_ = has_finite_bound_ || std::isfinite(report.counts.error_bound_px);
    }

    uint64_t seen() const { return seen_; }
    bool has_finite_bound() const { return has_finite_bound_; }

  private:
    splat::Model model_;
    scene::ModelPainter painter_;
    scene::Reference reference_;
    uint64_t seen_ = 0;
    bool has_finite_bound_ = false;
};

class Promises : public testing::TestWithParam<Case> {};

mesh::Mesh test_file(const char* name) {
    return mesh::read_mesh(std::string(QS_TEST_DATA) + "/" + name).mesh;
}

std::vector<Case> cases() {
    return {{"Tetrahedron", tetrahedron()},
            {"TwoTriangles", two_triangles()},
            {"Icosphere", icosphere(4)},
            {"BumpyTorus", bumpy_torus(60, 160, true)},
            {"FarTorus", shifted(bumpy_torus(30, 60), {4e5, 5e6, 100})},
            {"SmallTorus", scaled(bumpy_torus(30, 60), 1e-25)},
            {"Terrain", terrain(60)},
            {"Duplicates", with_duplicates()},
            {"MoebiusStrip", moebius_strip(80)},
            {"NeedleFan", needle_fan(300)},
            {"TestTiny", test_file("tiny.ply")},
            {"TestAscii", test_file("mesh-ascii.ply")},
            {"TestColours", test_file("mesh-normals-colours.ply")},
            {"TestStrips", test_file("mesh-strips.ply")},
            {"TestMapCoordinates", test_file("mesh-double-at-map-coordinates.ply")}};
}

}  // namespace

TEST_P(Promises, HoldFromOutsideAtAnyThreshold) {
    Subject subject(GetParam(), build_bytes(GetParam().mesh));
    std::vector<geom::View> views = random_views(subject.model(), GetParam().mesh, 20);
    views.push_back(fitted_view(subject.model()));
    for (const geom::View& view : views)
        for (const double threshold_px : kThresholds) {
            subject.expect_kept_promises(view, threshold_px, render::SplatKind::smooth);
            if (HasFailure()) return;  // one case is enough to look at
        }
    EXPECT_GT(subject.seen(), 0u);
    EXPECT_TRUE(subject.has_finite_bound());
}

TEST_P(Promises, HoldForEllipses) {
    Subject subject(GetParam(), build_bytes(GetParam().mesh));
    for (const geom::View& view : random_views(subject.model(), GetParam().mesh, 10))
        for (const double threshold_px : {0.0, 2.0, 8.0})
            subject.expect_kept_promises(view, threshold_px, render::SplatKind::ellipse);
}

TEST_P(Promises, HoldFromCloseBy) {
    Subject subject(GetParam(), build_bytes(GetParam().mesh));
    for (const geom::View& view : close_views(subject.model(), GetParam().mesh, 10))
        for (const double threshold_px : {0.0, 1.0, 8.0}) {
            subject.expect_kept_promises(view, threshold_px, render::SplatKind::smooth);
            if (HasFailure()) return;
        }
}

INSTANTIATE_TEST_SUITE_P(Mesh, Promises, testing::ValuesIn(cases()),
                         [](const auto& with) { return with.param.name; });

TEST(Prefix, OfAModelDrawsACompletePictureWithinItsBound) {
    const Case torus{"torus", bumpy_torus(100, 250)};
    const Bytes whole = build_bytes(torus.mesh);
    const splat::Header header = open_model(whole).header();
    ASSERT_GT(header.block_count, 64u);
    for (uint64_t blocks = 1; blocks < header.block_count; blocks = blocks * 3 / 2 + 1) {
        const auto size = std::ptrdiff_t(header.block_at(blocks) + 77);
        Subject subject(torus, Bytes(whole.begin(), whole.begin() + size));
        ASSERT_FALSE(subject.model().is_complete());
        std::vector<geom::View> views = random_views(subject.model(), torus.mesh, 4);
        views.push_back(fitted_view(subject.model()));
        for (const geom::View& view : views) {
            subject.expect_kept_promises(view, 1, render::SplatKind::smooth);
            ASSERT_FALSE(HasFailure()) << blocks << " blocks";
        }
    }
}
