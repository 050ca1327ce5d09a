// Models of the original QSplat program: every field of hand-made files, and what damage does to them.
#include "mesh/qsplat.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "core/error.h"
#include "mesh_check.h"
#include "test_files.h"

namespace {

using mesh::QsplatNode;

std::string read_file(const std::string& name) {
    std::ifstream in(kData + "qsplat/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

mesh::Source source_of(const std::string& bytes) {
    return {std::as_bytes(std::span(bytes)), "test.qs"};
}

struct Walked {
    mesh::QsplatFile file;
    std::vector<QsplatNode> nodes;
};

Walked walk(const std::string& bytes) {
    Walked walked;
    walked.file =
        mesh::walk_qsplat(source_of(bytes), [&](const QsplatNode& n) { walked.nodes.push_back(n); });
    return walked;
}

std::string message_of(const std::string& bytes) {
    try {
        walk(bytes);
    } catch (const core::Error& error) {
        return error.what();
    }
    return "accepted";
}

void expect_sphere(const QsplatNode& node, const glm::vec3& centre, float radius) {
    EXPECT_LT(glm::distance(node.sphere.centre, centre), 1e-5f);
    EXPECT_NEAR(node.sphere.radius, radius, 1e-5f);
}

// A step of a normal across its face, as the format has it.
double step(int k) {
    return std::tan(((k + 0.5) / 26 - 1) * M_PI / 4);
}

TEST(Qsplat, FieldsOfTwoLevels) {
    const Walked w = walk(read_file("two-levels.qs"));
    ASSERT_EQ(w.file.fragments.size(), 1u);
    const mesh::QsplatFragment& f = w.file.fragments[0];
    EXPECT_EQ(f.root.centre, glm::vec3(1, 2, 3));
    EXPECT_EQ(f.root.radius, 13);
    EXPECT_EQ(f.bytes, 60u);
    EXPECT_EQ(f.leaves, 3u);
    EXPECT_EQ(f.pointers, 1u);
    EXPECT_FALSE(f.has_colour);
    ASSERT_EQ(w.nodes.size(), 4u);
    // The cube of 6 cells from cell (0, 3, 7) on, a cell being 2 wide.
    expect_sphere(w.nodes[0], {1 - 13 + 6, 2 - 13 + 12, 3 - 13 + 20}, 6);
    EXPECT_EQ(w.nodes[0].children, 2u);
    EXPECT_EQ(w.nodes[0].cone, 2u);
    EXPECT_EQ(w.nodes[0].level, 1u);
    const double u = step(25), v = step(26);
    EXPECT_NEAR(w.nodes[0].normal.x, u, 1e-6);
    EXPECT_NEAR(w.nodes[0].normal.y, v, 1e-6);
    EXPECT_NEAR(w.nodes[0].normal.z, -std::sqrt(1 - u * u - v * v), 1e-6);
    expect_sphere(w.nodes[1], {1 - 13 + 25, 2 - 13 + 13, 3 - 13 + 13}, 1);
    EXPECT_EQ(w.nodes[1].children, 0u);
    EXPECT_GT(w.nodes[1].normal.x, 0.99f);
    // Children are coded against the first node.
    expect_sphere(w.nodes[2], w.nodes[0].sphere.centre, 6);
    EXPECT_EQ(w.nodes[2].level, 2u);
    // Face +y: across it z, then x.
    EXPECT_NEAR(w.nodes[2].normal.z, step(20), 1e-6);
    EXPECT_NEAR(w.nodes[2].normal.x, step(30), 1e-6);
    EXPECT_GT(w.nodes[2].normal.y, 0);
    EXPECT_LT(w.nodes[3].normal.y, 0);
    EXPECT_EQ(w.nodes[3].cone, 3u);
}

TEST(Qsplat, ColoursGrandchildrenAndNormalsThatNobodyHas) {
    const Walked w = walk(read_file("colour.qs"));
    ASSERT_EQ(w.nodes.size(), 11u);
    EXPECT_TRUE(w.file.fragments[0].has_colour);
    EXPECT_EQ(w.file.fragments[0].pointers, 2u);
    EXPECT_EQ(w.nodes[0].colour, glm::u8vec3(255, 0, 0));
    EXPECT_EQ(w.nodes[1].colour, glm::u8vec3(0, 255, 0));
    EXPECT_EQ(w.nodes[2].colour, glm::u8vec3(0, 0, 255));
    EXPECT_EQ(w.nodes[4].colour, glm::u8vec3(132, 130, 132));
    EXPECT_EQ(w.nodes[2].children, 4u);
    EXPECT_EQ(w.nodes[9].level, 3u);
    EXPECT_EQ(w.nodes[9].normal, glm::vec3(0));
}

TEST(Qsplat, WithoutAPointer) {
    const Walked w = walk(read_file("flat.qs"));
    ASSERT_EQ(w.nodes.size(), 2u);
    EXPECT_EQ(w.file.fragments[0].pointers, 0u);
}

TEST(Qsplat, FragmentsAndComments) {
    const Walked w = walk(read_file("fragments.qs"));
    EXPECT_EQ(w.file.comments, (std::vector<std::string>{"made by hand", "!"}));
    EXPECT_EQ(w.file.fragments.size(), 2u);
    EXPECT_EQ(w.nodes.size(), 15u);
    const mesh::ReadResult all = mesh::read_mesh(kData + "qsplat/fragments.qs");
    EXPECT_EQ(all.counts.format, "qsplat 11");
    EXPECT_EQ(all.mesh.positions.size(), 11u);
    EXPECT_EQ(all.mesh.radii.size(), 11u);
    EXPECT_EQ(all.mesh.colours[0], glm::u8vec3(255));
    EXPECT_EQ(all.mesh.colours[3], glm::u8vec3(0, 255, 0));
}

TEST(Qsplat, LevelsWithTheLeavesAboveThem) {
    const std::string bytes = read_file("colour.qs");
    EXPECT_EQ(mesh::read_qsplat(source_of(bytes), {}, 1).mesh.positions.size(), 3u);
    EXPECT_EQ(mesh::read_qsplat(source_of(bytes), {}, 2).mesh.positions.size(), 7u);
    EXPECT_EQ(mesh::read_qsplat(source_of(bytes), {}, 3).mesh.positions.size(), 8u);
}

TEST(Qsplat, NormalsAreNearestCodes) {
    double worst = 0;
    for (int a = 0; a < 200; ++a)
        for (int b = 0; b < 200; ++b) {
            const double z = (2 * a + 1) / 200.0 - 1, angle = 2 * M_PI * b / 200, r = std::sqrt(1 - z * z);
            const glm::vec3 n(glm::dvec3(r * std::cos(angle), r * std::sin(angle), z));
            const glm::vec3 decoded = mesh::decode_qsplat_normal(mesh::encode_qsplat_normal(n));
            worst = std::max(worst, std::acos(std::min(1.0, double(glm::dot(n, decoded)))));
        }
    EXPECT_LT(worst, 2.9 * M_PI / 180);
}

TEST(Qsplat, EveryCodeOfANormalIsUnitLengthOrNone) {
    for (uint32_t code = 0; code < mesh::kQsplatNormals; ++code) {
        const float length = glm::length(mesh::decode_qsplat_normal(code));
        EXPECT_TRUE(length == 0 || std::abs(length - 1) < 1e-6f) << code;
    }
}

TEST(Qsplat, ThereAre7621Spheres) {
    EXPECT_EQ(mesh::QsplatSpheres::get().count(), 7621u);
    const mesh::QsplatSphere parent{{1, 2, 3}, 4};
    const mesh::QsplatSphere whole =
        mesh::QsplatSpheres::get().decode(mesh::QsplatSpheres::get().code(13, {0, 0, 0}), parent);
    EXPECT_EQ(whole.centre, parent.centre);
    EXPECT_EQ(whole.radius, parent.radius);
}

struct Defect {
    const char* name;
    const char* file;
    size_t at;
    const char* bytes;  // what is written there, four bytes
    const char* message;
};

void PrintTo(const Defect& defect, std::ostream* out) {
    *out << defect.name;
}

using namespace std::string_literals;

const Defect kDefects[] = {
    {"version", "flat.qs", 6, "10\0\0",
     "fragment 1 at byte 0: begins with 'QSplat10'; only QSplat files of version 11 are read"},
    {"length_of_0", "flat.qs", 8, "\0\0\0\0", "fragment 1 at byte 8: a length of 0 bytes"},
    {"length_beyond", "flat.qs", 8, "\x7f\xff\xff\xff",
     "fragment 1 at byte 8: its length is 2147483647 bytes, and the file ends after 48: it is cut off"},
    {"leaves", "flat.qs", 12, "\0\0\0\3", "fragment 1 at byte 12: it is said to have 3 leaves and has 2"},
    {"options", "flat.qs", 16, "\0\0\0\4", "fragment 1 at byte 16: unknown options 0x4"},
    {"root_not_a_number", "flat.qs", 20, "\x7f\xc0\0\0",
     "fragment 1 at byte 20: the root's sphere is not finite, or has no size"},
    {"root_without_size", "flat.qs", 32, "\0\0\0\0",
     "fragment 1 at byte 20: the root's sphere is not finite, or has no size"},
    {"root_of_five", "flat.qs", 36, "\0\0\0\5",
     "fragment 1 at byte 36: the root has 5 children; it must have 1 to 4"},
    {"pointer", "two-levels.qs", 40, "\0\0\0\0",
     "fragment 1 at byte 40: a pointer of 0, where 12 is in order"},
    {"sphere", "flat.qs", 40, "\xff\xf8\0\0", "fragment 1 at byte 40: sphere code 8191; the last is 7620"},
    {"normal", "flat.qs", 42, "\xff\xfc\0\0", "fragment 1 at byte 42: normal code 16383; the last is 16223"},
    {"leaf_with_grandchildren", "flat.qs", 40, "\0\4\0\0",
     "fragment 1 at byte 40: a leaf with grandchildren"},
    {"children_without_a_pointer", "flat.qs", 40, "\0\1\0\0",
     "fragment 1 at byte 40: nodes with children and no pointer"},
};

class QsplatDefect : public testing::TestWithParam<Defect> {};

TEST_P(QsplatDefect, IsRefusedWithItsPlace) {
    const Defect& defect = GetParam();
    std::string bytes = read_file(defect.file);
    const size_t count = defect.at == 6 ? 2 : 4;
    bytes.replace(defect.at, count, std::string(defect.bytes, count));
    EXPECT_EQ(message_of(bytes), "test.qs: "s + defect.message);
}

INSTANTIATE_TEST_SUITE_P(Defects, QsplatDefect, testing::ValuesIn(kDefects),
                         [](const auto& test) { return std::string(test.param.name); });

class QsplatFiles : public testing::TestWithParam<const char*> {};

TEST_P(QsplatFiles, AreRefusedCutOffAnywhere) {
    const std::string whole = read_file(GetParam());
    const std::string_view fragments = "fragments.qs";
    for (size_t size = 1; size < whole.size(); ++size) {
        // Behind its first model the file may end between fragments.
        const bool ends_whole = GetParam() == fragments && (size == 92 || size == 208);
        EXPECT_EQ(message_of(whole.substr(0, size)) == "accepted", ends_whole) << size;
    }
}

TEST_P(QsplatFiles, WithAnyBitTurnedAreRefusedOrAreMeshes) {
    const std::string whole = read_file(GetParam());
    for (size_t bit = 0; bit < 8 * whole.size(); ++bit) {
        std::string bytes = whole;
        bytes[bit / 8] = char(bytes[bit / 8] ^ (1 << bit % 8));
        try {
            check_invariants(mesh::read_mesh_bytes(std::as_bytes(std::span(bytes)), "test.qs"));
        } catch (const core::Error&) {
        }
    }
}

INSTANTIATE_TEST_SUITE_P(All, QsplatFiles,
                         testing::Values("two-levels.qs", "colour.qs", "flat.qs", "fragments.qs"),
                         [](const auto& test) { return test_name_of(test.param); });

TEST(Qsplat, CommentsAloneAreNoModel) {
    const std::string bytes = read_file("fragments.qs").substr(0, 32);
    EXPECT_EQ(message_of(bytes), "test.qs: holds comments and no model");
}

}  // namespace
