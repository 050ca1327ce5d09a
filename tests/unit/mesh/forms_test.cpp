// Every form of every format gives the same mesh: the pyramid of tests/data/make-mesh-data, and a
// grid large enough for the parallel loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/parallel.h"
#include "mesh/mesh.h"
#include "mesh_check.h"
#include "test_files.h"

namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span<const char>(text));
}

constexpr std::array<std::array<double, 3>, 5> kPoints{
    {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1.5}}};
constexpr std::array<std::array<int, 3>, 5> kColours{
    {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 0}, {128, 64, 32}}};

// Which of the pyramid's points each vertex is; -1 where it is none of them.
std::vector<int> vertex_names(const mesh::Mesh& mesh, const glm::dvec3& offset, double tolerance) {
    std::vector<int> names;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        int name = -1;
        for (int k = 0; k < 5; ++k) {
            const auto& p = kPoints[static_cast<size_t>(k)];
            if (glm::distance(mesh.world(v) - offset, glm::dvec3(p[0], p[1], p[2])) <= tolerance) name = k;
        }
        names.push_back(name);
    }
    return names;
}

// Triangles as vertex names, each turned to begin with its smallest, sorted.
using Triangles = std::vector<std::array<int, 3>>;
Triangles named_triangles(const mesh::Mesh& mesh, const std::vector<int>& names) {
    Triangles out;
    for (const glm::u32vec3& t : mesh.triangles) {
        std::array<int, 3> named{names[t.x], names[t.y], names[t.z]};
        std::rotate(named.begin(), std::min_element(named.begin(), named.end()), named.end());
        out.push_back(named);
    }
    std::sort(out.begin(), out.end());
    return out;
}

enum Fans { kSquareFromZero, kStrips, kCloud };

struct Form {
    const char* file;
    const char* format;
    uint64_t faces;
    Fans fans = kSquareFromZero;
    bool has_normals = false, has_colours = false;
    bool may_have_origin = false;  // beside 0
    glm::dvec3 offset{0};
    double tolerance = 1e-6;
};

void PrintTo(const Form& form, std::ostream* out) {
    *out << form.file;
}

const Form kForms[] = {
    {"mesh-ascii.ply", "ply ascii", 5},
    {"mesh-little-endian.ply", "ply binary_little_endian", 6},
    {"mesh-big-endian.ply", "ply binary_big_endian", 5},
    {"mesh-cr-lines.ply", "ply ascii", 5},
    {"mesh-crlf-lines.ply", "ply ascii", 5},
    {"mesh-crlf-header.ply", "ply binary_little_endian", 6},
    {"mesh-blanks.ply", "ply ascii", 5},
    {"mesh-double-at-map-coordinates.ply",
     "ply binary_little_endian",
     6,
     kSquareFromZero,
     false,
     false,
     true,
     {637000.01, 852000.02, 500}},
    {"mesh-mixed-types.ply", "ply binary_little_endian", 5, kSquareFromZero, false, true, true},
    {"mesh-normals-colours.ply", "ply binary_little_endian", 6, kSquareFromZero, true, true},
    {"mesh-float-colours.ply", "ply ascii", 0, kCloud, false, true},
    {"mesh-ushort-colours.ply", "ply binary_little_endian", 0, kCloud, false, true},
    {"mesh-faces-first.ply", "ply binary_little_endian", 5},
    {"mesh-elements-around.ply", "ply binary_little_endian", 5},
    {"mesh-elements-around-ascii.ply", "ply ascii", 5},
    {"mesh-list-in-vertex.ply", "ply binary_big_endian", 5},
    {"mesh-strips.ply", "ply binary_little_endian", 3, kStrips},
    {"mesh-strips-ascii.ply", "ply ascii", 3, kStrips},
    {"mesh-cloud.ply", "ply binary_little_endian", 0, kCloud},
    {"mesh-repeated-index.ply", "ply binary_little_endian", 7},
    {"mesh-plain.obj", "obj", 5, kSquareFromZero, false, false, true},
    {"mesh-all-of-f.obj", "obj", 5, kSquareFromZero, true, true, true},
    {"mesh-plain.off", "off", 5, kSquareFromZero, false, false, true},
    {"mesh-colours.off", "off", 5, kSquareFromZero, false, true, true},
    {"mesh-normals.off", "off", 5, kSquareFromZero, true, false, true},
    {"mesh-binary.off", "off binary", 5},
    {"mesh-binary-all.off", "off binary", 5, kSquareFromZero, true, true},
    {"mesh-ascii.stl", "stl ascii", 6, kSquareFromZero, false, false, true},
    {"mesh-binary.stl", "stl binary", 6},
};

class Pyramid : public testing::TestWithParam<Form> {};

TEST_P(Pyramid, IsTheSameInEveryForm) {
    const Form& form = GetParam();
    const mesh::ReadResult result = mesh::read_mesh(kData + form.file);
    const mesh::Mesh& mesh = result.mesh;
    check_invariants(result);
    EXPECT_EQ(result.counts.format, form.format);
    EXPECT_EQ(result.counts.faces_in, form.faces);
    EXPECT_TRUE(form.may_have_origin || mesh.origin == glm::dvec3(0));
    EXPECT_LT(glm::length(mesh.origin - form.offset), 2);  // among the points

    const std::vector<int> names = vertex_names(mesh, form.offset, form.tolerance);
    ASSERT_EQ(names.size(), 5u);
    std::vector<int> sorted = names;
    std::sort(sorted.begin(), sorted.end());
    ASSERT_EQ(sorted, (std::vector<int>{0, 1, 2, 3, 4}));
    const Triangles from_zero{{0, 1, 4}, {0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {1, 2, 4}, {2, 3, 4}};
    const Triangles strips{{0, 1, 4}, {0, 3, 1}, {0, 4, 3}, {1, 2, 4}, {1, 3, 2}, {2, 3, 4}};
    // The square's first corner is 0 in the file and its own first in a strip.
    EXPECT_EQ(named_triangles(mesh, names), form.fans == kCloud    ? Triangles{}
                                            : form.fans == kStrips ? strips
                                                                   : from_zero);

    EXPECT_EQ(mesh.normals.size(), form.has_normals ? 5u : 0u);
    for (size_t v = 0; v < mesh.normals.size(); ++v) {
        const glm::dvec3 p = mesh.world(v);
        EXPECT_LT(glm::distance(glm::dvec3(mesh.normals[v]), glm::normalize(glm::dvec3(p.x, p.y, 1))), 1e-5);
    }
    EXPECT_EQ(mesh.colours.size(), form.has_colours ? 5u : 0u);
    for (size_t v = 0; v < mesh.colours.size(); ++v) {
        const auto& c = kColours[static_cast<size_t>(names[v])];
        EXPECT_EQ(glm::ivec3(mesh.colours[v]), glm::ivec3(c[0], c[1], c[2]));
    }
}

INSTANTIATE_TEST_SUITE_P(Forms, Pyramid, testing::ValuesIn(kForms),
                         [](const auto& test) { return test_name_of(test.param.file); });

TEST(ReadMesh, ReadsAnEmptyMesh) {
    const mesh::ReadResult result = mesh::read_mesh(kData + "mesh-empty.ply");
    EXPECT_TRUE(result.mesh.positions.empty());
    EXPECT_TRUE(result.mesh.is_cloud());
}

TEST(ReadMesh, KeepsIntegersBeyondSinglePrecisionExact) {
    const mesh::Mesh mesh = mesh::read_mesh(kData + "mesh-integers.ply").mesh;
    EXPECT_EQ(mesh.world(0), glm::dvec3(1999999999.0, -1, 0));
    EXPECT_EQ(mesh.world(4), glm::dvec3(2000000000.0, 0, 3));
}

TEST(ReadMesh, CountsAFaceThatNamesAVertexTwice) {
    const mesh::ReadCounts counts = mesh::read_mesh(kData + "mesh-repeated-index.ply").counts;
    EXPECT_EQ(counts.triangles_in, 7u);
    EXPECT_EQ(counts.triangles_dropped, (std::map<std::string, uint64_t>{{"repeated_index", 1}}));
}

TEST(ReadMesh, CountsWeldedCorners) {
    const mesh::ReadCounts counts = mesh::read_mesh(kData + "mesh-binary.stl").counts;
    EXPECT_EQ(counts.vertices_in, 18u);
    EXPECT_EQ(counts.vertices_dropped, (std::map<std::string, uint64_t>{{"welded", 13}}));
}

TEST(ReadMesh, DropsAVertexThatIsNotFiniteWithItsFacesWhereAsked) {
    const mesh::ReadResult result = mesh::read_mesh(kData + "bad/mesh-nan.ply", {.skip_bad = true});
    check_invariants(result);
    EXPECT_EQ(result.mesh.positions.size(), 4u);
    EXPECT_EQ(result.mesh.triangles, (std::vector<glm::u32vec3>{{0, 3, 2}, {0, 2, 1}}));
    EXPECT_EQ(result.counts.vertices_dropped, (std::map<std::string, uint64_t>{{"not_finite", 1}}));
    EXPECT_EQ(result.counts.triangles_dropped, (std::map<std::string, uint64_t>{{"not_finite_vertex", 4}}));
}

TEST(ReadMesh, DropsCoordinatesTooLargeForSinglePrecisionWhereAsked) {
    const mesh::ReadResult result =
        mesh::read_mesh(kData + "bad/mesh-too-large-for-single.ply", {.skip_bad = true});
    check_invariants(result);
    EXPECT_EQ(result.mesh.positions.size(), 4u);
    EXPECT_LT(glm::length(result.mesh.origin), 2);  // the point left out does not move it
}

// Many files have such a vertex, in no face.
TEST(ReadMesh, KeepsTheDigitsOfMostPointsWhateverAFewAre) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 101\nproperty double x\nproperty double y\nproperty double "
        "z\nend_header\n";
    for (int i = 0; i < 100; ++i) text += core::text("%.17g 5e6 %.17g\n", 6e5 + 1e-3 * i, -1e-3 * i);
    for (const char* far : {"1e30 0 0\n", "6e5 1e15 0\n", "-1e300 nan 0\n", "inf 5e6 0\n"}) {
        const std::string all = text + far;
        const mesh::Mesh mesh =
            mesh::read_mesh_bytes(std::as_bytes(std::span(all)), "far.ply", {.skip_bad = true}).mesh;
        for (size_t i = 0; i < 100; ++i) {
            const glm::dvec3 expected(6e5 + 1e-3 * double(i), 5e6, -1e-3 * double(i));
            EXPECT_LT(glm::length(mesh.world(i) - expected), 1e-8) << far;
        }
    }
}

TEST(ReadMesh, ReadsEveryNotationOfANumber) {
    const std::string text =
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty double y\nproperty float z\n"
        "end_header\n+1.5e+1 -.5 1e-400\n5. +0x 0\n";
    EXPECT_THROW(mesh::read_mesh_bytes(bytes_of(text), "a.ply"), core::Error);
    std::string good = text;
    good.replace(good.find("+0x"), 3, "+07");
    const mesh::Mesh mesh = mesh::read_mesh_bytes(bytes_of(good), "a.ply").mesh;
    EXPECT_EQ(mesh.world(0), glm::dvec3(15, -0.5, 0));
    EXPECT_EQ(mesh.world(1), glm::dvec3(5, 7, 0));
}

// A grid of side * side vertices in any of the binary forms.
template <class T>
void put(std::string& out, T value, bool is_swapped) {
    std::array<char, sizeof(T)> bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (is_swapped) std::reverse(bytes.begin(), bytes.end());
    out.append(bytes.data(), bytes.size());
}

std::string grid_ply(int side, bool is_swapped, int last_index, bool ends_with_square) {
    const int squares = (side - 1) * (side - 1);
    std::string out = core::text(
        "ply\nformat binary_%s_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
        "property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n",
        is_swapped ? "big" : "little", side * side, 2 * squares + 1);
    for (int i = 0; i < side * side; ++i) {
        put(out, static_cast<float>(i % side), is_swapped);
        put(out, static_cast<float>(i / side), is_swapped);
        put(out, static_cast<float>(i % 7), is_swapped);
    }
    const auto face = [&](std::initializer_list<int> corners) {
        put(out, static_cast<uint8_t>(corners.size()), is_swapped);
        for (const int corner : corners) put(out, corner, is_swapped);
    };
    for (int s = 0; s < squares; ++s) {
        const int v = s / (side - 1) * side + s % (side - 1);
        face({v, v + 1, v + side});
        face({v + 1, v + side + 1, v + side});
    }
    if (ends_with_square)
        face({0, 1, side, last_index});
    else
        face({0, 1, last_index});
    return out;
}

constexpr int kSide = 400;  // 160,000 vertices: several pieces of the parallel loops

TEST(ReadMesh, GivesTheSameMeshWhateverTheByteOrderAndThreadCount) {
    const std::string little = grid_ply(kSide, false, 2, false);
    core::set_thread_count(1);
    const mesh::ReadResult one = mesh::read_mesh_bytes(bytes_of(little), "grid.ply");
    EXPECT_EQ(one.mesh.positions.size(), 160000u);
    EXPECT_EQ(one.mesh.positions.back(), glm::vec3(399, 399, 159999 % 7));
    EXPECT_EQ(one.mesh.triangles.back(), glm::u32vec3(0, 1, 2));
    core::set_thread_count(4);
    const std::string big = grid_ply(kSide, true, 2, false);
    for (const std::string* text : {&little, &big}) {
        const mesh::ReadResult other = mesh::read_mesh_bytes(bytes_of(*text), "grid.ply");
        EXPECT_EQ(other.mesh.positions, one.mesh.positions);
        EXPECT_EQ(other.mesh.triangles, one.mesh.triangles);
    }
    core::set_thread_count(0);
}

TEST(ReadMesh, ReadsOneSquareBehindManyTriangles) {
    const mesh::ReadResult mixed =
        mesh::read_mesh_bytes(bytes_of(grid_ply(kSide, false, 7, true)), "grid.ply");
    check_invariants(mixed);
    EXPECT_EQ(mixed.counts.faces_in, 2u * 399 * 399 + 1);
    ASSERT_EQ(mixed.mesh.triangles.size(), 2u * 399 * 399 + 2);
    EXPECT_EQ(mixed.mesh.triangles.back(), glm::u32vec3(0, 400, 7));
}

TEST(ReadMesh, NamesTheFaceOfAnIndexOutOfRangeInAnyPiece) {
    try {
        mesh::read_mesh_bytes(bytes_of(grid_ply(kSide, false, 160000, false)), "grid.ply");
        FAIL() << "accepted";
    } catch (const core::Error& error) {
        EXPECT_STREQ(error.what(), "grid.ply: face 318402 uses vertex 160000, file has 160000 vertices");
    }
}

TEST(ReadMesh, NamesTheFirstVertexThatIsNotFiniteInAnyPiece) {
    std::string text = grid_ply(kSide, false, 2, false);
    const float infinite = INFINITY;
    for (const size_t v : {150000u, 159999u})
        std::memcpy(text.data() + text.find("end_header\n") + 11 + 12 * v + 4, &infinite, 4);
    try {
        mesh::read_mesh_bytes(bytes_of(text), "grid.ply");
        FAIL() << "accepted";
    } catch (const core::Error& error) {
        EXPECT_STREQ(error.what(),
                     "grid.ply: vertex 150000: coordinate is not finite (qs-build and pm-build drop it with "
                     "--skip-bad)");
    }
}

TEST(ToPly, RoundTripsEveryForm) {
    for (const Form& form : kForms) {
        const mesh::Mesh mesh = mesh::read_mesh(kData + form.file).mesh;
        const mesh::Mesh again = mesh::read_mesh_bytes(bytes_of(mesh::to_ply(mesh)), "again.ply").mesh;
        EXPECT_EQ(again.triangles, mesh.triangles) << form.file;
        EXPECT_EQ(again.colours, mesh.colours) << form.file;
        ASSERT_EQ(again.normals.size(), mesh.normals.size()) << form.file;
        for (size_t v = 0; v < mesh.normals.size(); ++v)
            EXPECT_LT(glm::distance(again.normals[v], mesh.normals[v]), 1e-6f) << form.file;
        ASSERT_EQ(again.positions.size(), mesh.positions.size()) << form.file;
        for (size_t v = 0; v < mesh.positions.size(); ++v)
            EXPECT_EQ(again.world(v), mesh.world(v)) << form.file << " vertex " << v;
    }
}

}  // namespace
