// Files that others made: every one is read with the counts known for it, or refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "mesh/mesh.h"
#include "mesh_check.h"
#include "test_files.h"

namespace {

const std::string kShared = QS_SHARED_DATA "/";

struct RealFile {
    const char* file;
    uint64_t vertices = 0, faces = 0;  // as in the file
    const char* refusal = nullptr;
    bool skip_bad = false;
    uint64_t triangles_kept = 0, vertices_kept = 0;  // 0: as many as faces, vertices
    bool has_normals = false, has_colours = false;
};

void PrintTo(const RealFile& file, std::ostream* out) {
    *out << file.file;
}

const RealFile kFiles[] = {
    {.file = "armadillo.ply", .vertices = 43243, .faces = 86482},
    {.file = "autzen-stadium-crop.ply", .vertices = 207784, .faces = 0, .has_colours = true},
    {.file = "bunny.ply", .vertices = 35947, .faces = 69451},
    {.file = "ct-cranium-skin-bone.ply", .vertices = 566091, .faces = 1128516, .has_colours = true},
    {.file = "dragon.ply", .vertices = 437645, .faces = 871414},
    {.file = "gargoyle-colour.ply",
     .vertices = 25002,
     .faces = 50000,
     .has_normals = true,
     .has_colours = true},
    {.file = "horse-big-endian.ply", .vertices = 48485, .faces = 96966, .has_colours = true},
    {.file = "lucy-100k.ply", .vertices = 49987, .faces = 99970},
    {.file = "odd/abominevole-nonmanifold.off", .vertices = 5021, .faces = 50706},
    {.file = "odd/ascii-extra-list-element.ply", .vertices = 5, .faces = 0},
    {.file = "odd/box-material-element.ply",
     .vertices = 24,
     .faces = 8,
     .triangles_kept = 12,
     .has_normals = true,
     .has_colours = true},
    {.file = "odd/bunny-8k-nonmanifold.ply", .vertices = 8171, .faces = 16301},
    {.file = "odd/bunny-tristrips.ply", .vertices = 34834, .faces = 8023, .triangles_kept = 69451},
    {.file = "odd/busted.stl", .vertices = 11634, .faces = 3878, .vertices_kept = 1941},
    {.file = "odd/crlf-header-binary.ply", .vertices = 8, .faces = 12},
    {.file = "odd/degenerate-slivers.off", .vertices = 8, .faces = 8},
    {.file = "odd/dragon-23k-nonmanifold.ply", .vertices = 22998, .faces = 47794},
    {.file = "odd/elephant-with-holes.off", .vertices = 2798, .faces = 4463},
    {.file = "odd/empty-ascii.ply", .vertices = 0, .faces = 0},
    {.file = "odd/extra-whitespace.ply", .vertices = 3, .faces = 1, .has_colours = true},
    {.file = "odd/face-before-vertex.ply", .vertices = 50, .faces = 50, .triangles_kept = 80},
    {.file = "odd/face-count-overflow.off",
     .refusal = "line 2: 353535235358 vertices in the 293 bytes that are left"},
    {.file = "odd/face-extra-property.ply", .vertices = 4, .faces = 2},
    {.file = "odd/float-colour.ply", .vertices = 3, .faces = 1, .has_colours = true},
    {.file = "odd/fuze-texcoord-lists.ply", .vertices = 502, .faces = 1000, .has_colours = true},
    {.file = "odd/header-name-corrupt.ply", .refusal = "line 7: '?\?\?' is not a PLY type"},
    {.file = "odd/inf-nan.obj",
     .refusal = "line 1: coordinate is not finite (qs-build and pm-build drop it with --skip-bad)"},
    {.file = "odd/inf-points.ply",
     .refusal = "vertex 0: coordinate is not finite (qs-build and pm-build drop it with --skip-bad)"},
    {.file = "odd/inf-points.ply", .vertices = 16, .faces = 0, .skip_bad = true, .vertices_kept = 13},
    {.file = "odd/int-coordinates.ply", .vertices = 16, .faces = 0},
    {.file = "odd/no-vertex-element.ply", .refusal = "header: there is no vertex element"},
    {.file = "odd/out-of-range-index.obj", .refusal = "line 23: face 0 uses vertex 12, file has 8 vertices"},
    {.file = "odd/points-diffuse-colour.ply",
     .vertices = 70051,
     .faces = 0,
     .has_normals = true,
     .has_colours = true},
    {.file = "odd/points-with-face-element-0.ply", .vertices = 1024, .faces = 0},
    {.file = "odd/polygons-big-endian.ply", .vertices = 50, .faces = 50, .triangles_kept = 80},
    {.file = "odd/polygons-degenerate.off", .vertices = 90, .faces = 52, .triangles_kept = 180},
    {.file = "odd/sized-type-names.ply", .refusal = "header: the vertex element lacks x, y or z"},
    {.file = "odd/stereo-organised-nan.ply",
     .refusal = "vertex 0: coordinate is not finite (qs-build and pm-build drop it with --skip-bad)"},
    {.file = "odd/stereo-organised-nan.ply",
     .vertices = 76800,
     .faces = 0,
     .skip_bad = true,
     .vertices_kept = 76800 - 24491,
     .has_colours = true},
};

class RealFiles : public testing::TestWithParam<RealFile> {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(kShared)) GTEST_SKIP() << "the folder of real models is not there";
    }
};

TEST_P(RealFiles, AreReadAsTheyAre) {
    const RealFile& expected = GetParam();
    const std::string path = kShared + expected.file;
    mesh::ReadResult result;
    try {
        result = mesh::read_mesh(path, {.skip_bad = expected.skip_bad});
        ASSERT_EQ(expected.refusal, nullptr) << "accepted";
    } catch (const core::Error& error) {
        ASSERT_EQ(error.what(),
                  path + ": " + (expected.refusal != nullptr ? expected.refusal : "(accepted)"));
        return;
    }
    check_invariants(result);
    const auto or_else = [](uint64_t count, uint64_t other) { return count != 0 ? count : other; };
    const mesh::Mesh& mesh = result.mesh;
    EXPECT_EQ(result.counts.vertices_in, expected.vertices);
    EXPECT_EQ(result.counts.faces_in, expected.faces);
    EXPECT_EQ(mesh.positions.size(), or_else(expected.vertices_kept, expected.vertices));
    EXPECT_EQ(mesh.triangles.size(), or_else(expected.triangles_kept, expected.faces));
    EXPECT_EQ(!mesh.normals.empty(), expected.has_normals);
    EXPECT_EQ(!mesh.colours.empty(), expected.has_colours);
}

std::string file_name(const testing::TestParamInfo<RealFile>& info) {
    return test_name_of(info.param.file) + (info.param.skip_bad ? "_skip_bad" : "");
}
INSTANTIATE_TEST_SUITE_P(Shared, RealFiles, testing::ValuesIn(kFiles), file_name);

TEST(RealFiles, MapCoordinatesKeepTheirCentimetres) {
    const std::string path = kShared + "autzen-stadium-crop.ply";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "the folder of real models is not there";
    const mesh::Mesh mesh = mesh::read_mesh(path).mesh;
    double worst = 0;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const glm::dvec3 steps = mesh.world(v) * 100.0;  // coordinates stand in steps of 0.01
        const glm::dvec3 off = glm::abs(steps - glm::round(steps)) / 100.0;
        worst = std::max({worst, off.x, off.y, off.z});
    }
    EXPECT_LT(worst, 1e-4);
}

}  // namespace
