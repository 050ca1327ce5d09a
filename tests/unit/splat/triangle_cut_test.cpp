// Cuts that hand out triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>

#include "splat/cut.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

constexpr splat::BuildOptions kTriangles{.leaf = splat::Leaf::triangle};

struct Handed {
    std::vector<std::array<glm::vec3, 3>> triangles, normals;
    std::vector<uint32_t> colours;
    uint64_t splats = 0;
    double widest_splat_px = 0;
    splat::CutCounts counts;
};

geom::View view_of(const splat::Model& model, double distance) {
    const splat::Header& h = model.header();
    geom::Camera camera;
    camera.eye = h.origin + h.scale * distance * glm::dvec3(0.48, 0.6, 0.64);
    camera.target = h.origin;
    return geom::make_view(camera, 640, 480);
}

Handed cut_model(const splat::Model& model, const geom::View& view, const splat::CutOptions& options) {
    splat::Cut cut(model);
    Handed handed;
    const size_t tasks = cut.begin(view, options);
    for (size_t t = 0; t < tasks; ++t)
        cut.run(
            t,
            [&](const geom::SplatBatch& b) {
                handed.splats += uint64_t(b.count);
                for (int i = 0; i < b.count; ++i)
                    handed.widest_splat_px = std::max(
                        handed.widest_splat_px, 2 * double(b.radius[i]) * view.focal_px / double(b.z[i]));
            },
            nullptr,
            [&](const geom::TriangleBatch& b) {
                for (int i = 0; i < b.count; ++i) {
                    handed.triangles.push_back({}), handed.normals.push_back({});
                    for (int k = 0; k < 3; ++k) {
                        handed.triangles.back()[size_t(k)] = {b.x[k][i], b.y[k][i], b.z[k][i]};
                        handed.normals.back()[size_t(k)] = {b.nx[k][i], b.ny[k][i], b.nz[k][i]};
                    }
                    handed.colours.push_back(b.colour[i]);
                }
            });
    handed.counts = cut.counts();
    return handed;
}

splat::CutOptions leaves_from(double triangle_px) {
    splat::CutOptions options;
    options.threshold_px = 0;
    options.cull_backfaces = false;
    options.triangle_px = triangle_px;
    return options;
}

std::array<uint32_t, 3> bits_of(const glm::vec3& p) {
    std::array<uint32_t, 3> bits;
    std::memcpy(bits.data(), &p, sizeof(bits));
    return bits;
}

}  // namespace

TEST(TriangleCut, HandsOutEveryTriangleOnce) {
    for (const NamedMesh& m : generated_meshes()) {
        splat::BuildReport report;
        const Bytes bytes = build_bytes(m.mesh, kTriangles, &report);
        const splat::Model model = open_model(bytes);
        const Handed handed = cut_model(model, view_of(model, 6), leaves_from(0));
        EXPECT_EQ(handed.splats, 0u) << m.name;
        EXPECT_EQ(handed.counts.triangles, m.mesh.triangles.size()) << m.name;
        EXPECT_EQ(handed.triangles.size(), m.mesh.triangles.size() - report.triangles.degenerate) << m.name;
    }
}

// In a closed mesh every edge has its reverse, found by the bits of its ends.
TEST(TriangleCut, SharedCornersAreTheSameToTheBit) {
    const splat::Model model = build_model(bumpy_torus(300, 400), kTriangles);
    for (const double distance : {6.0, 1.0, 0.2}) {
        const Handed handed = cut_model(model, view_of(model, distance), leaves_from(0));
        std::map<std::array<std::array<uint32_t, 3>, 2>, int> edges;
        for (const auto& t : handed.triangles)
            for (size_t k = 0; k < 3; ++k) {
                const auto a = bits_of(t[k]), b = bits_of(t[(k + 1) % 3]);
                ++edges[{a, b}], --edges[{b, a}];
            }
        if (distance == 6.0) {
            EXPECT_EQ(handed.triangles.size(), 2u * 300 * 400);
        }
        size_t lone = 0;
        for (const auto& [edge, count] : edges) lone += count != 0;
        // Where the view ends the surface does.
        EXPECT_LT(lone, distance == 6.0 ? 1 : edges.size() / 4) << distance;
    }
}

TEST(TriangleCut, CornersAreWhereTheLatticeHasThem) {
    const mesh::Mesh mesh = icosphere(3);
    const splat::Model model = build_model(mesh, kTriangles);
    const splat::Header& h = model.header();
    const geom::View view = view_of(model, 2);
    const double rounding = std::ldexp(0.87, -int(h.lattice_bits));
    for (const auto& t : cut_model(model, view, leaves_from(0)).triangles)
        for (const glm::vec3& p : t) {
            const glm::dvec3 world =
                view.eye +
                h.scale * (double(p.x) * view.right + double(p.y) * view.down + double(p.z) * view.forward);
            double nearest = 1;
            for (size_t v = 0; v < mesh.positions.size(); ++v)
                nearest = std::min(nearest, glm::length(mesh.world(v) - world));
            ASSERT_LT(nearest, h.scale * (rounding + 1e-6));
        }
}

TEST(TriangleCut, LargeLeavesAreTrianglesAndSmallOnesSplats) {
    const splat::Model model = build_model(bumpy_torus(60, 160), kTriangles);
    const geom::View view = view_of(model, 2);
    const Handed all = cut_model(model, view, leaves_from(0));
    uint64_t last = all.triangles.size();
    for (const double px : {2.0, 4.0, 8.0, 16.0, 1e9}) {
        const Handed handed = cut_model(model, view, leaves_from(px));
        EXPECT_EQ(handed.splats + handed.triangles.size(), all.triangles.size());
        EXPECT_LE(handed.triangles.size(), last);
        EXPECT_LT(handed.widest_splat_px, 2 * px);
        last = handed.triangles.size();
    }
    EXPECT_EQ(last, 0u);
    EXPECT_EQ(cut_model(model, view, leaves_from(std::numeric_limits<double>::infinity())).triangles.size(),
              0u);
}

// A block is not read for a few triangles, unless they are large.
TEST(TriangleCut, BlocksOfSmallTrianglesAreSplats) {
    mesh::Mesh mesh = bumpy_torus(60, 160);
    for (glm::vec3& p : mesh.positions) p.x += 20;
    // One triangle beside many that are much smaller.
    const auto first = uint32_t(mesh.positions.size());
    for (const glm::vec3& p : {glm::vec3(19, 0, 0), glm::vec3(21, 0, 0), glm::vec3(20, 1, 0)})
        mesh.positions.push_back(p);
    mesh.triangles.emplace_back(first, first + 1, first + 2);
    mesh.colours.resize(mesh.colours.empty() ? 0 : mesh.positions.size());
    mesh.normals.resize(mesh.normals.empty() ? 0 : mesh.positions.size());
    const splat::Model model = build_model(mesh, kTriangles);
    const geom::View view = view_of(model, 3);
    double px = 1;
    while (cut_model(model, view, leaves_from(px)).triangles.size() > 1) px *= 1.1;
    const Handed handed = cut_model(model, view, leaves_from(px));
    EXPECT_EQ(handed.triangles.size(), 1u);
    EXPECT_GT(handed.widest_splat_px, px);
    EXPECT_LT(handed.widest_splat_px, 2 * px);
}

TEST(TriangleCut, ErrorOfTrianglesIsTheLatticeStep) {
    const splat::Model model = build_model(icosphere(4), kTriangles);
    const geom::View view = view_of(model, 3);
    const double exact = cut_model(model, view, leaves_from(0)).counts.error_bound_px;
    EXPECT_GT(exact, 0);
    EXPECT_LT(exact, view.focal_px / 2 * std::ldexp(1.0, -int(model.header().lattice_bits)));
    EXPECT_GT(cut_model(model, view, leaves_from(1e9)).counts.error_bound_px, 20 * exact);
}

TEST(TriangleCut, FarViewsTouchNoTriangles) {
    const Bytes bytes = build_bytes(bumpy_torus(300, 400), kTriangles);
    const splat::Model model = open_model(bytes);
    splat::CutOptions with, without;
    with.triangle_px = 4;
    const geom::View view = view_of(model, 40);
    const Handed a = cut_model(model, view, with), b = cut_model(model, view, without);
    EXPECT_EQ(a.counts.blocks_touched, b.counts.blocks_touched);
    EXPECT_EQ(a.splats, b.splats);
    EXPECT_EQ(a.counts.triangles, 0u);
    EXPECT_LT(a.counts.blocks_touched, model.header().node_blocks());
}

TEST(TriangleCut, OfAPrefixDrawsSplatsWhereTrianglesAreMissing) {
    const Bytes whole = build_bytes(bumpy_torus(60, 160), kTriangles);
    const splat::Header h = splat::parse_header(whole, "");
    for (const uint64_t blocks :
         {h.node_blocks() / 2, h.node_blocks(), (h.node_blocks() + h.block_count) / 2, h.block_count}) {
        const Bytes bytes(whole.begin(), whole.begin() + ptrdiff_t(h.block_at(blocks)));
        const splat::Model model = open_model(bytes);
        const Handed handed = cut_model(model, view_of(model, 6), leaves_from(0));
        EXPECT_EQ(handed.triangles.empty(), blocks <= h.node_blocks());
        EXPECT_EQ(handed.splats == 0, blocks == h.block_count);
        EXPECT_EQ(handed.counts.groups_missing, handed.splats);
        if (blocks >= h.node_blocks()) {
            EXPECT_EQ(handed.splats + handed.triangles.size(), h.leaf_count);
        }
    }
}

TEST(TriangleCut, NormalsAreOfUnitLengthAndColoursTheTriangles) {
    mesh::Mesh mesh = bumpy_torus(30, 60, true);
    const splat::Model model = build_model(mesh, kTriangles);
    const geom::View view = view_of(model, 2);
    const Handed handed = cut_model(model, view, leaves_from(0));
    for (size_t i = 0; i < handed.triangles.size(); ++i) {
        const auto& t = handed.triangles[i];
        const glm::vec3 own = glm::normalize(glm::cross(t[1] - t[0], t[2] - t[0]));
        for (const glm::vec3& n : handed.normals[i]) {
            ASSERT_NEAR(glm::length(n), 1, 1e-5);
            ASSERT_GT(glm::dot(n, own), 0.5);
        }
    }
    EXPECT_GT(std::count_if(handed.colours.begin(), handed.colours.end(),
                            [&](uint32_t c) { return c != handed.colours[0]; }),
              0);
}
