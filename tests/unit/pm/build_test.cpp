#include "pm/build.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "pm/build/details.h"
#include "pm/build/writer.h"
#include "pm/extract.h"
#include "pm/verify.h"
#include "test_models.h"

namespace {

using namespace pm_test;

// The input as a lattice of so many bits has it.
mesh::Mesh rounded(const mesh::Mesh& mesh, const pm::Header& h) {
    mesh::Mesh out = mesh;
    for (glm::vec3& p : out.positions) {
        const glm::dvec3 unit = (glm::dvec3(p) - h.placement.low) / h.placement.extent;
        const glm::dvec3 lattice = glm::floor(unit * h.steps() + 0.5) / h.steps();
        p = glm::vec3(h.placement.low + lattice * h.placement.extent);
    }
    return out;
}

TEST(Build, FullyRefinedIsTheRoundedInput) {
    for (const NamedMesh& shape : all_shapes())
        for (const uint32_t bits : {6u, 14u, 20u}) {
            pm::BuildOptions options;
            options.bits = bits;
            const pm::Model model = build_model(shape.mesh, options);
            const mesh::Mesh full = pm::mesh_of_level(model, model.details());
            EXPECT_EQ(placed(full), placed(rounded(without_duplicates(shape.mesh), model.header())))
                << shape.name << ", " << bits;
        }
}

TEST(Build, LosslessIsTheInputBitForBit) {
    for (const NamedMesh& shape : all_shapes()) {
        const pm::Model model = build_model(shape.mesh, lossless());
        const mesh::Mesh full = pm::mesh_of_level(model, model.details());
        EXPECT_EQ(placed(full), placed(without_duplicates(shape.mesh))) << shape.name;
        EXPECT_EQ(full.origin, shape.mesh.origin) << shape.name;
    }
}

TEST(Build, IsVerifiedWhateverTheShape) {
    for (const NamedMesh& shape : all_shapes())
        for (const bool is_lossless : {false, true})
            for (const bool flip_test : {false, true}) {
                pm::BuildOptions options = is_lossless ? lossless() : pm::BuildOptions{};
                options.flip_test = flip_test;
                options.with_normals = is_lossless;
                EXPECT_NO_THROW(pm::verify(build_model(shape.mesh, options))) << shape.name;
            }
}

TEST(Build, IsTheSameBytesForAnyNumberOfThreads) {
    for (const mesh::Mesh& mesh :
         {splat_test::icosphere(3), splat_test::soup(200), splat_test::bumpy_torus(40, 60, true)}) {
        core::set_thread_count(1);
        const Bytes one = build_bytes(mesh);
        core::set_thread_count(7);
        const Bytes seven = build_bytes(mesh);
        core::set_thread_count(0);
        EXPECT_EQ(one, seven);
    }
}

// The faces of every power of two are those of the first: nothing in it knows how large a unit is.
TEST(Build, IsTheSameHierarchyAtAnyScale) {
    const mesh::Mesh mesh = splat_test::bumpy_torus(12, 30);
    const pm::Model one = build_model(mesh);
    for (const int exponent : {-100, -40, 40, 100}) {
        const pm::Model other = build_model(splat_test::scaled(mesh, std::exp2(exponent)));
        EXPECT_TRUE(std::equal(one.content().begin(), one.content().end(), other.content().begin(),
                               other.content().end()))
            << exponent;
    }
}

TEST(Build, SimplifiesClosedSurfacesToAHandfulOfFaces) {
    EXPECT_EQ(build_model(splat_test::tetrahedron()).details(), 0u);
    EXPECT_EQ(build_model(one_triangle()).details(), 0u);
    EXPECT_LE(build_model(splat_test::icosphere(3)).header().base_faces, 8u);
    EXPECT_LE(build_model(splat_test::bumpy_torus(12, 30)).header().base_faces, 40u);
}

TEST(Build, KeepsAttributesWithTheirVertices) {
    mesh::Mesh mesh = splat_test::bumpy_torus(12, 30, true);
    for (size_t v = 0; v < mesh.positions.size(); ++v) mesh.colours[v] = glm::u8vec3(v % 251, v / 251, 7);
    mesh.normals.clear();
    pm::BuildOptions options = lossless();
    options.with_normals = true;
    const pm::Model model = build_model(mesh, options);
    ASSERT_TRUE(model.header().has_colours() && model.header().has_normals());
    for (uint32_t v = 0; v < model.vertices(); ++v) {
        const glm::u8vec3 colour = model.colour(v);
        const size_t source = size_t(colour.r) + 251 * size_t(colour.g);
        ASSERT_EQ(model.single(v), mesh.positions[source]);
    }
    options.keep_colours = options.with_normals = false;
    const pm::Model bare = build_model(mesh, options);
    EXPECT_FALSE(bare.header().has_colours() || bare.header().has_normals());
    EXPECT_LT(bare.size_bytes(), model.size_bytes());
}

TEST(Build, RefusesBarePoints) {
    core::OutputFile out(core::OutputFile::InMemory{"model"});
    EXPECT_THROW(pm::build(splat_test::cloud(50), {}, out, "points"), core::Error);
}

// A fan whose rim is collapsed from its end on: every detail is the child of the one before.  No pass of
// independent edges makes one as deep.
TEST(Details, OfAHierarchyAHundredSplitsDeepAreAModel) {
    constexpr uint32_t kDepth = 100;
    std::vector<glm::dvec3> positions{{0, 0, 0}};
    for (uint32_t v = 0; v < kDepth + 2; ++v)
        positions.emplace_back(std::cos(0.01 * v), std::sin(0.01 * v), 0);
    pm::SimplifyResult simplified;
    for (uint32_t f = 0; f < kDepth + 1; ++f) simplified.faces.emplace_back(0, f + 1, f + 2);
    const std::vector<glm::u32vec3> faces = simplified.faces;
    simplified.base_faces = {0};
    simplified.base_vertices = {0, 1, 2};
    for (uint32_t f = kDepth; f > 0; --f)
        simplified.collapses.push_back(
            {f + 2, f + 1, pm::kNone, 3 * f + 2, {2.0, 1.0 / f, pm::NormalCone{}}});
    const pm::Details details = pm::make_details(positions, faces, std::move(simplified), true);
    pm::Header h;
    h.flags = pm::kOpenSurface, h.bits = 0;
    h.base_vertices = 3, h.base_faces = 1, h.details = kDepth, h.depth = details.depth, h.faces = kDepth + 1;
    pm::VertexData vertices;
    for (const uint32_t v : details.vertex) vertices.single.emplace_back(positions[v]);
    core::OutputFile out(core::OutputFile::InMemory{"model"});
    pm::write_model(h, details, vertices, {}, out);
    const pm::Model model(out.read_back());
    EXPECT_EQ(model.header().depth, kDepth);
    EXPECT_NO_THROW(pm::verify(model));
    const mesh::Mesh full = pm::mesh_of_level(model, kDepth);
    EXPECT_EQ(full.triangles.size(), faces.size());
    pm::Front front(model.hierarchy());
    for (uint32_t d = 0; d < kDepth; ++d) {
        EXPECT_EQ(front.can_collapse(0), d == 1);
        ASSERT_TRUE(front.can_split(d));
        front.split(d);
    }
    for (uint32_t d = kDepth; d-- > 0;) {
        ASSERT_TRUE(front.can_collapse(d));
        front.collapse(d);
    }
    EXPECT_EQ(front.face_count(), 1u);
}

TEST(Build, TakesLongStrips) {
    const pm::Model model = build_model(strip(3000));
    EXPECT_NO_THROW(pm::verify(model));
    EXPECT_EQ(model.header().faces, 3000u);
}

TEST(Build, SplitsOffWhatItCutAndWeldsItAgain) {
    const pm::Model model = build_model(bow_tie(), lossless());
    EXPECT_EQ(model.vertices(), 8u);
    EXPECT_EQ(model.welds().size(), 1u);
    EXPECT_EQ(pm::mesh_of_level(model, model.details()).positions.size(), 7u);
}

}  // namespace
