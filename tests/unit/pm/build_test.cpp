#include "pm/build.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
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

// What is worst for a tree: every split of one path.
TEST(Build, TakesDeepHierarchies) {
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
