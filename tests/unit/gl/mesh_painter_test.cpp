// The two exact renderers, ours and the one of OpenGL, agree.
#include "gl/mesh_painter.h"

#include <cmath>

#include "frames.h"
#include "geom/path.h"
#include "render/raster.h"
#include "test_meshes.h"

namespace {

using gl_test::Difference;
using render::Frame;
using render::Shade;

// What the two promise each other: a pixel is covered by one alone where an edge passes its centre within
// GL's rounding of vertices.
constexpr double kLeastPsnrDb = 55;
constexpr double kMostApart = 1e-4;

class MeshPainter : public testing::TestWithParam<const char*> {
  protected:
    void expect_agreement(const mesh::Mesh& mesh, const geom::View& view, Shade shade = Shade::lit) {
        std::string reason;
        std::unique_ptr<gl::Device> device = gl_test::open(GetParam(), reason);
        if (!device) GTEST_SKIP() << reason;
        Frame exact, drawn;
        render::MeshRaster(mesh).draw(view, {shade, {10, 20, 30}}, exact);
        gl::MeshPainter(std::move(device), mesh).draw(view, {shade, {10, 20, 30}}, drawn);
        const Difference d = gl_test::difference(drawn, exact);
        EXPECT_GE(d.psnr_db, kLeastPsnrDb) << d;
        EXPECT_LE(d.covered_apart, kMostApart) << d;
        EXPECT_LE(d.depth, 1e-4) << d;
    }
};

geom::View view_of(const geom::Camera& camera, int width = 640, int height = 480) {
    return geom::make_view(camera, width, height);
}

const geom::Camera kBeside{{1.5, 2, 4.5}, {0, 0, 0}};

}  // namespace

TEST_P(MeshPainter, AgreesOnGeneratedMeshes) {
    for (const splat_test::NamedMesh& named : splat_test::generated_meshes()) {
        SCOPED_TRACE(named.name);
        if (named.mesh.is_cloud()) continue;
        glm::dvec3 low = named.mesh.world(0), high = low;
        for (size_t v = 0; v < named.mesh.positions.size(); ++v)
            low = glm::min(low, named.mesh.world(v)), high = glm::max(high, named.mesh.world(v));
        const geom::Sphere bounds{0.5 * (low + high), 0.5 * glm::distance(low, high)};
        const geom::Camera camera = geom::orbit(bounds, {.frames = 1}).front();
        expect_agreement(named.mesh, view_of(camera, 1280, 720));
    }
}

TEST_P(MeshPainter, AgreesOnEveryShade) {
    const mesh::Mesh mesh = splat_test::bumpy_torus(60, 160, true);
    for (const Shade shade : {Shade::lit, Shade::normal, Shade::flat, Shade::level})
        expect_agreement(mesh, view_of(kBeside), shade);
}

TEST_P(MeshPainter, AgreesBetweenNearAndFarAndFromInside) {
    const mesh::Mesh mesh = splat_test::bumpy_torus(60, 160, true);
    geom::Camera cut = kBeside;
    cut.near = 4.5, cut.far = 5.5;
    expect_agreement(mesh, view_of(cut));
    expect_agreement(mesh, view_of({{1, 0, 0.1}, {0, 1, 0}, {0, 0, 1}, 100}));
}

TEST_P(MeshPainter, AgreesOnPartsAndOddSizes) {
    const mesh::Mesh mesh = splat_test::icosphere(4);
    expect_agreement(mesh, view_of({{0, 0, 3}, {0, 0, 0}}, 1, 1));
    expect_agreement(mesh, view_of({{0, 0, 3}, {0, 0, 0}}, 3001, 401));
}

TEST_P(MeshPainter, AgreesOnAPartOffTheAxis) {
    geom::View view = view_of(kBeside);
    view.shift_px = {30.25, -17};
    expect_agreement(splat_test::bumpy_torus(60, 160), geom::part_of(view, 301, 167, 250, 190));
}

TEST_P(MeshPainter, AgreesFarFromTheOriginAndAtAnyScale) {
    for (const double scale : {1e-20, 1e15}) {
        const mesh::Mesh mesh = splat_test::scaled(splat_test::icosphere(4), scale);
        expect_agreement(mesh, view_of({{0, 0, 3 * scale}, {0, 0, 0}}));
    }
    mesh::Mesh mesh = splat_test::icosphere(4);
    mesh.origin = {1e9, -1e9, 1e9};
    expect_agreement(mesh, view_of({mesh.origin + glm::dvec3(0, 0, 3), mesh.origin}));
}

TEST_P(MeshPainter, AgreesOnTheFilesOfTheTests) {
    for (const char* file : {"tiny.ply", "mesh-colours.off", "mesh-plain.obj", "mesh-binary.stl"}) {
        SCOPED_TRACE(file);
        const mesh::Mesh mesh = mesh::read_mesh(std::string(QS_TEST_DATA "/") + file).mesh;
        glm::dvec3 sum(0);
        double reach = 0;
        for (size_t v = 0; v < mesh.positions.size(); ++v)
            sum += mesh.world(v) / double(mesh.positions.size());
        for (size_t v = 0; v < mesh.positions.size(); ++v)
            reach = std::max(reach, glm::distance(mesh.world(v), sum));
        expect_agreement(mesh, view_of({sum + reach * glm::dvec3(1.5, 2, 3), sum}));
    }
}

TEST_P(MeshPainter, DrawsTheNextFrameAsIfItWereTheFirst) {
    std::string reason;
    std::unique_ptr<gl::Device> device = gl_test::open(GetParam(), reason);
    if (!device) GTEST_SKIP() << reason;
    const mesh::Mesh mesh = splat_test::bumpy_torus(30, 80, true);
    gl::MeshPainter painter(std::move(device), mesh);
    Frame first, again;
    painter.draw(view_of(kBeside), {}, first);
    painter.draw(view_of({{0, 5, 1}, {0, 0, 0}}, 900, 20), {Shade::level}, again);
    painter.draw(view_of(kBeside), {}, again);
    EXPECT_EQ(first.rgb, again.rgb);
    EXPECT_EQ(first.depth, again.depth);
}

INSTANTIATE_TEST_SUITE_P(Contexts, MeshPainter, testing::ValuesIn(gl_test::kDrawingContexts));
