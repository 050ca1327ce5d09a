// Models written for the original QSplat program, read back.
#include "splat/qsplat_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "mesh/qsplat.h"
#include "test_meshes.h"

namespace {

using mesh::QsplatNode;
using mesh::QsplatSphere;
using splat_test::Random;

struct Written {
    splat::QsplatReport report;
    core::InputFile file;

    explicit Written(mesh::Mesh mesh)
        : Written(std::move(mesh), core::OutputFile(core::OutputFile::InMemory{"test.qs"})) {}

    std::vector<QsplatNode> nodes(mesh::QsplatFile* info = nullptr) const {
        std::vector<QsplatNode> nodes;
        const mesh::QsplatFile file_info =
            mesh::walk_qsplat({file.bytes(), "test.qs"}, [&](const QsplatNode& n) { nodes.push_back(n); });
        if (info) *info = file_info;
        return nodes;
    }

  private:
    Written(mesh::Mesh mesh, core::OutputFile&& out)
        : report(splat::write_qsplat(std::move(mesh), "test.ply", out)), file(out.read_back()) {}
};

std::string message_of(mesh::Mesh mesh) {
    try {
        Written written(std::move(mesh));
    } catch (const core::Error& error) {
        return error.what();
    }
    return "written";
}

// Meshes that the format can hold.
std::vector<splat_test::NamedMesh> meshes() {
    return {{"tetrahedron", splat_test::tetrahedron()},
            {"icosphere", splat_test::icosphere(3)},
            {"torus", splat_test::bumpy_torus(60, 24, true)},
            {"terrain", splat_test::terrain(24)},
            {"needles", splat_test::needle_fan(50)},
            {"duplicates", splat_test::with_duplicates()},
            {"soup", splat_test::soup(60)},
            {"large", splat_test::scaled(splat_test::icosphere(2), 1e20)},
            {"small", splat_test::scaled(splat_test::icosphere(2), 1e-20)},
            {"moved", splat_test::shifted(splat_test::icosphere(3), {1000, 0, -500})}};
}

class QsplatWriter : public testing::TestWithParam<splat_test::NamedMesh> {};

// Of every level, with the leaves above it.
TEST_P(QsplatWriter, EveryCutCoversEveryTriangle) {
    const mesh::Mesh mesh = GetParam().mesh;
    const Written written(mesh);
    const std::vector<QsplatNode> nodes = written.nodes();
    Random random(1);
    std::vector<glm::dvec3> points;
    for (const glm::u32vec3& t : mesh.triangles) {
        double a = random.unit(), b = random.unit();
        if (a + b > 1) a = 1 - a, b = 1 - b;
        points.push_back(mesh.world(t.x) * (1 - a - b) + mesh.world(t.y) * a + mesh.world(t.z) * b);
    }
    for (uint32_t level = 1; level <= written.report.levels; ++level) {
        std::vector<QsplatSphere> cut;
        for (const QsplatNode& n : nodes)
            if (n.level == level || (n.level < level && !n.children)) cut.push_back(n.sphere);
        for (const glm::dvec3& p : points)
            EXPECT_TRUE(std::any_of(cut.begin(), cut.end(),
                                    [&](const QsplatSphere& s) {
                                        return glm::distance(p, glm::dvec3(s.centre)) <=
                                               double(s.radius) * (1 + 1e-6);
                                    }))
                << "level " << level;
    }
}

TEST_P(QsplatWriter, CountsAgree) {
    const mesh::Mesh mesh = GetParam().mesh;
    const Written written(mesh);
    mesh::QsplatFile info;
    const std::vector<QsplatNode> nodes = written.nodes(&info);
    EXPECT_EQ(nodes.size(), written.report.nodes);
    EXPECT_EQ(info.fragments.at(0).leaves, written.report.leaves);
    EXPECT_EQ(written.file.bytes().size(), written.report.file_bytes);
    EXPECT_EQ(written.report.leaves + written.report.unreferenced, mesh.positions.size());
    EXPECT_EQ(nodes.back().level, written.report.levels);
    EXPECT_GE(written.report.leaf_inflation_mean, 1.0);
    // What the original's reader takes for granted.
    EXPECT_GE(info.fragments[0].pointers, 1u);
}

TEST_P(QsplatWriter, ConesHoldTheNormalsOfTheFaces) {
    const mesh::Mesh mesh = GetParam().mesh;
    const std::vector<QsplatNode> nodes = Written(mesh).nodes();
    // The root's children hold all leaves: each face's normal is in one of their cones.
    std::vector<QsplatNode> top;
    for (const QsplatNode& n : nodes)
        if (n.level == 1) top.push_back(n);
    for (const glm::u32vec3& t : mesh.triangles) {
        const glm::dvec3 a = mesh.world(t.x), b = mesh.world(t.y), c = mesh.world(t.z);
        const glm::vec3 normal = mesh::unit_normal(glm::cross(b - a, c - a));
        if (normal == glm::vec3(0)) continue;
        EXPECT_TRUE(std::any_of(top.begin(), top.end(), [&](const QsplatNode& n) {
            return n.cone == 3 || std::acos(std::clamp(double(glm::dot(n.normal, normal)), -1.0, 1.0)) <=
                                      std::asin(double(mesh::decode_qsplat_cone(n.cone))) + 1e-6;
        }));
    }
}

TEST_P(QsplatWriter, IsTheSameForAnyNumberOfThreads) {
    std::vector<std::string> files;
    for (const int threads : {1, 2, 7}) {
        core::set_thread_count(threads);
        const Written written(GetParam().mesh);
        const auto bytes = written.file.bytes();
        files.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    core::set_thread_count(0);
    EXPECT_EQ(files[0], files[1]);
    EXPECT_EQ(files[0], files[2]);
}

INSTANTIATE_TEST_SUITE_P(Meshes, QsplatWriter, testing::ValuesIn(meshes()),
                         [](const auto& test) { return test.param.name; });

TEST(QsplatWriterLimits, KeepsColours) {
    mesh::Mesh mesh = splat_test::tetrahedron();
    mesh.colours = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 255}};
    mesh::QsplatFile info;
    std::vector<glm::u8vec3> leaves;
    for (const QsplatNode& n : Written(mesh).nodes(&info))
        if (!n.children) leaves.push_back(n.colour);
    EXPECT_TRUE(info.fragments[0].has_colour);
    for (const glm::u8vec3& colour : mesh.colours)
        EXPECT_EQ(std::count(leaves.begin(), leaves.end(), colour), 1);
}

TEST(QsplatWriterLimits, RefusesWhatTheFormatCannotHold) {
    mesh::Mesh two;
    two.positions = {{0, 0, 0}, {1, 0, 0}};
    EXPECT_EQ(message_of(two), "test.ply: has 2 vertices; a QSplat file holds at least 3");
    EXPECT_EQ(message_of({}), "test.ply: has 0 vertices; a QSplat file holds at least 3");
    const std::string far = message_of(splat_test::shifted(splat_test::icosphere(3), {1e7, 0, 0}));
    EXPECT_NE(far.find("move the model to the origin"), std::string::npos) << far;
    const std::string large = message_of(splat_test::scaled(splat_test::icosphere(1), 1e28));
    EXPECT_NE(large.find("a QSplat file's may be from 1e-25 to 1e+25"), std::string::npos) << large;
}

TEST(QsplatWriterLimits, CloudsAreNeverCulled) {
    for (const QsplatNode& n : Written(splat_test::cloud(200)).nodes()) EXPECT_EQ(n.cone, 3u);
}

TEST(QsplatWriterLimits, EqualPointsAreParted) {
    mesh::Mesh mesh = splat_test::cloud(3);
    for (int k = 0; k < 100; ++k) mesh.positions.push_back(mesh.positions[0]);
    mesh.normals.clear();
    EXPECT_EQ(Written(mesh).report.leaves, 103u);
}

}  // namespace
