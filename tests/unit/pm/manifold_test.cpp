#include "pm/build/manifold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/parallel.h"
#include "test_models.h"

namespace {

using namespace pm_test;

// Faces about every vertex: the arc of neighbours that they make, as the number of ends it has and its
// pieces.
void expect_one_fan_each(const pm::Manifold& m, const char* name) {
    std::vector<std::vector<std::pair<uint32_t, uint32_t>>> arcs(m.source.size());
    for (const glm::u32vec3& f : m.faces)
        for (int k = 0; k < 3; ++k) arcs[f[k]].emplace_back(f[(k + 1) % 3], f[(k + 2) % 3]);
    for (size_t v = 0; v < arcs.size(); ++v) {
        ASSERT_FALSE(arcs[v].empty()) << name;
        std::map<uint32_t, uint32_t> after;
        std::set<uint32_t> ends;
        for (const auto& [from, to] : arcs[v]) after[from] = to, ends.insert(to);
        uint32_t at = arcs[v][0].first;
        for (const auto& [from, to] : arcs[v])
            if (!ends.contains(from)) at = from;
        size_t steps = 0;
        for (; steps < arcs[v].size() && after.contains(at); ++steps) at = after[at];
        EXPECT_EQ(steps, arcs[v].size()) << name << ", vertex " << v;
    }
}

TEST(Manifold, HasEveryDirectedEdgeOnceAndOneFanAVertex) {
    for (const NamedMesh& shape : all_shapes()) {
        const pm::Manifold m = pm::make_manifold(shape.mesh.triangles, shape.mesh.positions);
        std::set<std::pair<uint32_t, uint32_t>> edges;
        for (const glm::u32vec3& f : m.faces)
            for (int k = 0; k < 3; ++k) EXPECT_TRUE(edges.emplace(f[k], f[(k + 1) % 3]).second) << shape.name;
        for (const glm::u32vec2& e : m.boundary) EXPECT_FALSE(edges.contains({e.y, e.x})) << shape.name;
        expect_one_fan_each(m, shape.name);
    }
}

TEST(Manifold, HasTheInputsFacesOnce) {
    for (const NamedMesh& shape : all_shapes()) {
        const pm::Manifold m = pm::make_manifold(shape.mesh.triangles, shape.mesh.positions);
        std::vector<glm::u32vec3> back;
        for (const glm::u32vec3& f : m.faces) back.emplace_back(m.source[f.x], m.source[f.y], m.source[f.z]);
        EXPECT_EQ(sorted(back), sorted(without_duplicates(shape.mesh).triangles)) << shape.name;
        EXPECT_EQ(m.duplicate_faces + m.faces.size(), shape.mesh.triangles.size()) << shape.name;
        std::set<uint32_t> used(m.source.begin(), m.source.end());
        EXPECT_EQ(m.unreferenced + used.size(), shape.mesh.positions.size()) << shape.name;
        EXPECT_EQ(m.welds.size() + used.size(), m.source.size()) << shape.name;
        for (const pm::Weld& w : m.welds) EXPECT_EQ(m.source[w.copy], m.source[w.of]) << shape.name;
    }
}

TEST(Manifold, OfAManifoldCutsNothing) {
    for (const mesh::Mesh& mesh :
         {splat_test::tetrahedron(), splat_test::icosphere(2), splat_test::terrain(9)}) {
        const pm::Manifold m = pm::make_manifold(mesh.triangles, mesh.positions);
        EXPECT_EQ(m.cut_edges, 0u);
        EXPECT_TRUE(m.welds.empty());
        EXPECT_EQ(sorted(m.faces), sorted(mesh.triangles));
    }
}

TEST(Manifold, OfRandomTrianglesOverFewVerticesIsOne) {
    Random random(7);
    for (int round = 0; round < 300; ++round) {
        const uint32_t vertices = 3 + uint32_t(random.bits() % 8);
        std::vector<glm::u32vec3> faces;
        for (uint64_t f = random.bits() % 40; f > 0; --f) {
            const glm::u32vec3 face(random.bits() % vertices, random.bits() % vertices,
                                    random.bits() % vertices);
            if (face.x != face.y && face.y != face.z && face.z != face.x) faces.push_back(face);
        }
        std::vector<glm::vec3> positions;
        for (uint32_t v = 0; v < vertices; ++v) positions.emplace_back(random.direction());
        const pm::Manifold m = pm::make_manifold(faces, positions);
        std::set<std::pair<uint32_t, uint32_t>> edges;
        for (const glm::u32vec3& f : m.faces)
            for (int k = 0; k < 3; ++k) EXPECT_TRUE(edges.emplace(f[k], f[(k + 1) % 3]).second);
        expect_one_fan_each(m, "random");
    }
}

// Two boxes' corners that touch along an edge fall apart as they are, and a flap that hangs on a surface
// falls off.
TEST(Manifold, PartsSolidsThatTouchAndFlaps) {
    mesh::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}, {2, 1, 0}, {2, -1, 0}, {-2, 1, 0}, {-2, -1, 0}};
    mesh.triangles = {{1, 0, 3}, {0, 1, 2}, {3, 0, 2}, {2, 1, 3}, {1, 0, 4}, {0, 1, 5}, {4, 0, 5}, {5, 1, 4}};
    const pm::Manifold two = pm::make_manifold(mesh.triangles, mesh.positions);
    EXPECT_EQ(two.cut_edges, 1u);
    EXPECT_EQ(two.welds.size(), 2u);
    EXPECT_TRUE(two.boundary.empty());
    for (const uint32_t place : {3u, 0u}) {  // behind the first tetrahedron, and in it
        mesh::Mesh flap = mesh;
        flap.triangles.resize(4);
        flap.positions[4] = glm::vec3(place == 0 ? 3 : -3, 0, 0.5);
        flap.triangles.insert(flap.triangles.end(), {{0, 1, 4}, {1, 0, 4}});
        flap.positions.resize(5);
        const pm::Manifold m = pm::make_manifold(flap.triangles, flap.positions);
        EXPECT_EQ(m.boundary.size(), 0u) << place;
        EXPECT_EQ(m.welds.size(), 2u) << place;
    }
}

}  // namespace
