// What is wrong is said in one sentence, and nothing crashes on the way.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/error.h"
#include "mesh/mesh.h"
#include "mesh_check.h"
#include "test_files.h"

namespace {

struct Defect {
    const char* file;     // of tests/data/bad, after "mesh-"
    const char* message;  // after the file's name
};

void PrintTo(const Defect& defect, std::ostream* out) {
    *out << defect.file;
}

const Defect kDefects[] = {
    {"binary-cut-off.off", "face 4: 3 colour components in the 10 bytes that are left"},
    {"binary-huge-colour.off", "face 4: 2147483647 colour components in the 12 bytes that are left"},
    {"binary-huge-face.off", "face 4: 2147483647 corners in the 32 bytes that are left"},
    {"binary-index-out-of-range.off", "face 4 uses vertex -1, file has 5 vertices"},
    {"binary-lying-face-count.off", "header: 2147483647 faces in the 204 bytes that are left"},
    {"binary-lying-vertex-count.off", "header: 2147483647 vertices in the 204 bytes that are left"},
    {"binary-nan.off", "vertex 4: coordinate is not finite (qs-build and pm-build drop it with --skip-bad)"},
    {"binary-negative-count.off", "header: -5 vertices"},
    {"binary-no-counts.off", "header: the file ends at byte 10"},
    {"binary-too-many-faces.off", "36 bytes stand after the last face"},
    {"count-beyond-64-bits.ply", "line 3: '99999999999999999999' is not a whole number"},
    {"count-too-small-ascii.ply", "line 19: '4' stands after the last element of the header"},
    {"count-too-small.ply", "13 bytes stand after the last element of the header"},
    {"cut-off-ascii.ply", "line 19: the file ends in face 4 of 5"},
    {"cut-off.off", "line 11: expected 3 corners, found 2"},
    {"cut-off.ply", "face 5 of 6: the file ends at byte 302, 5 more are needed"},
    {"cut-off.stl", "header: 6 triangles make 384 bytes, the file has 383"},
    {"empty-file.ply", "the file is empty"},
    {"extra-byte.stl", "header: 6 triangles make 384 bytes, the file has 385"},
    {"float-index.ply", "header: the vertex indices of element 'face' are not of an integer type"},
    {"float-list-count.ply", "line 8: a list's count is not of an integer type"},
    {"four-dimensions.off", "line 2: only three-dimensional OFF is read"},
    {"huge-list-count.ply", "face 0 of 1: the file ends at byte 248, 17179869164 more are needed"},
    {"index-before-first.obj", "line 7: face 0 uses vertex -6, file has 5 vertices"},
    {"index-out-of-range-ascii.ply", "face 4 uses vertex 70000, file has 5 vertices"},
    {"index-out-of-range.obj", "line 7: face 0 uses vertex 6, file has 5 vertices"},
    {"index-out-of-range.off", "face 4 uses vertex 5, file has 5 vertices"},
    {"index-out-of-range.ply", "face 5 uses vertex 5, file has 5 vertices"},
    {"index-zero.obj", "line 7: face 0 uses vertex 0, file has 5 vertices"},
    {"infinity-ascii.ply",
     "vertex 4: coordinate is not finite (qs-build and pm-build drop it with --skip-bad)"},
    {"lying-count-ascii.ply",
     "header: element 'vertex' has 4000000000 records, too many for the 78 bytes left"},
    {"lying-face-count.off", "line 2: 353535235358 faces in the 81 bytes that are left"},
    {"lying-face-count.ply",
     "header: element 'face' has 9000000000000000000 records of at least 1 bytes, 78 bytes are left (cut "
     "off?)"},
    {"lying-vertex-count.off", "line 2: 353535235358 vertices in the 83 bytes that are left"},
    {"lying-vertex-count.ply",
     "header: element 'vertex' has 4000000000 records of 12 bytes, 138 bytes are left (cut off?)"},
    {"missing-value.ply", "line 11: vertex 0 does not end with its line, as the header's properties would"},
    {"nan.obj", "line 6: coordinate is not finite (qs-build and pm-build drop it with --skip-bad)"},
    {"nan.ply", "vertex 4: coordinate is not finite (qs-build and pm-build drop it with --skip-bad)"},
    {"negative-count.ply", "line 3: element 'vertex' has the count '-5'"},
    {"negative-index.ply", "face 5 uses vertex -1, file has 5 vertices"},
    {"negative-list-count.ply", "face 0: a list of -3 values"},
    {"no-end-of-header.ply", "line 8: the file ends inside the header"},
    {"no-end.stl", "line 43: the file ends without 'endsolid'"},
    {"no-vertex-element.ply", "header: there is no vertex element"},
    {"no-z.ply", "header: the vertex element lacks x, y or z"},
    {"normal-out-of-range.obj", "line 7: face 0 uses normal 1, file has 0 normals before it"},
    {"nul-in-header.ply", "line 6: '?\?\?' is not a PLY type"},
    {"text.txt", "header: neither PLY, OBJ, OFF, STL, Draco nor QSplat"},
    {"too-few-corners.off", "line 12: expected 4 corners, found 3"},
    {"too-large-for-single.ply",
     "vertex 4: coordinate is too large for single precision (qs-build and pm-build drop it with "
     "--skip-bad)"},
    {"too-many-faces.off", "line 12: '4' stands after the last face"},
    {"two-coordinates.obj", "line 4: expected 3 coordinates, found 2"},
    {"two-coordinates.off", "line 5: expected 3 coordinates, found 2"},
    {"two-corners.stl", "line 6: a facet of 2 vertices"},
    {"unknown-format.ply", "line 2: 'middle_endian' is not a PLY format"},
    {"unknown-keyword.obj", "line 7: 'face' is not a keyword of OBJ"},
    {"unknown-keyword.ply", "line 7: 'elemnt' is not a keyword of a PLY header"},
    {"unknown-type.ply", "line 6: 'quad' is not a PLY type"},
    {"version-2.ply", "line 2: PLY version '2.0', only 1.0 is known"},
    {"word-for-number.ply", "line 14: 'one' is not a number"},
};

class BadMesh : public testing::TestWithParam<Defect> {};

TEST_P(BadMesh, IsRefusedWithOneSentence) {
    const std::string path = kData + "bad/mesh-" + GetParam().file;
    try {
        mesh::read_mesh(path);
        FAIL() << "accepted";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.what(), path + ": " + GetParam().message);
    }
}

INSTANTIATE_TEST_SUITE_P(Defects, BadMesh, testing::ValuesIn(kDefects),
                         [](const auto& test) { return test_name_of(test.param.file); });

// Of what people have beside meshes, the refusal says what to do with it.
TEST(BadMesh, OfAnotherKindIsCalledByItsName) {
    const std::pair<std::string, std::string> kKinds[] = {
        {"LASF",
         "a LAS or LAZ cloud of points, which is not read; make it PLY first, as 'pdal translate INPUT "
         "OUTPUT.ply' does"},
        {"ASTM-E57",
         "an E57 cloud of points, which is not read; make it PLY first, as 'pdal translate INPUT OUTPUT.ply' "
         "does"},
        {"qs-model", "a splat model already; what it was made of is wanted"},
        {"qspmesh\n", "a progressive mesh already; what it was made of is wanted"},
        {"ObjectType = Image\n", "a MetaImage volume, which ppve-sample draws, and nothing else"},
        {"\x89PNG\r\n", "a PNG picture, which is neither a mesh nor a cloud of points that is read"}};
    for (const auto& [beginning, is] : kKinds) {
        const std::string bytes = beginning + std::string(1000, '\1');
        try {
            mesh::read_mesh_bytes(std::as_bytes(std::span(bytes)), "scan", {});
            FAIL() << "accepted";
        } catch (const core::Error& error) {
            EXPECT_EQ(error.what(), "scan: " + is);
        }
    }
}

TEST(BadMesh, EveryFileOfTheFolderIsInTheTable) {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(kData + "bad"))
        count += entry.path().filename().string().starts_with("mesh-") && entry.path().extension() != ".drc";
    EXPECT_EQ(count, std::size(kDefects));
}

TEST(ReadMesh, RefusesAFileThatIsNotThere) {
    EXPECT_THROW(mesh::read_mesh(kData + "mesh-nowhere.ply"), core::Error);
    EXPECT_THROW(mesh::read_mesh(kData), core::Error);
}

// How many cuts may go unnoticed: blanks, colours and last digits at the end of a text.  An OBJ may end
// between any two lines.
struct Whole {
    const char* file;
    size_t most_accepted;
};

void PrintTo(const Whole& whole, std::ostream* out) {
    *out << whole.file;
}

class Truncated : public testing::TestWithParam<Whole> {};

// Cut after every byte: refused, or a mesh whose counts add up.
TEST_P(Truncated, IsRefusedOrAValidMesh) {
    const std::string name = GetParam().file;
    std::ifstream in(kData + name, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    ASSERT_FALSE(whole.empty());
    size_t accepted = 0;
    for (size_t size = 0; size < whole.size(); ++size) {
        const std::vector<char> part(whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size));
        try {
            check_invariants(mesh::read_mesh_bytes(std::as_bytes(std::span(part)), name));
            ++accepted;
        } catch (const core::Error& error) {
            EXPECT_EQ(std::string(error.what()).find(name + ": "), 0u) << error.what();
        }
    }
    EXPECT_LE(accepted, GetParam().most_accepted);
}
constexpr size_t kAny = ~size_t{0};
const Whole kWholes[] = {{"mesh-ascii.ply", 1},
                         {"mesh-little-endian.ply", 0},
                         {"mesh-big-endian.ply", 0},
                         {"mesh-elements-around.ply", 0},
                         {"mesh-elements-around-ascii.ply", 1},
                         {"mesh-strips.ply", 0},
                         {"mesh-plain.obj", kAny},
                         {"mesh-all-of-f.obj", kAny},
                         {"mesh-plain.off", 1},
                         {"mesh-colours.off", sizeof " 200 0 0"},
                         {"mesh-binary.off", 0},
                         {"mesh-binary-all.off", 0},
                         {"mesh-ascii.stl", sizeof " pyramid"},
                         {"mesh-binary.stl", 0}};
INSTANTIATE_TEST_SUITE_P(Formats, Truncated, testing::ValuesIn(kWholes));

}  // namespace
