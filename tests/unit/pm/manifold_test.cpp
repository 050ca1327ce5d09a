#include "pm/manifold.h"

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
        const pm::Manifold m = pm::make_manifold(shape.mesh.triangles, uint32_t(shape.mesh.positions.size()));
        std::set<std::pair<uint32_t, uint32_t>> edges;
        for (const glm::u32vec3& f : m.faces)
            for (int k = 0; k < 3; ++k) EXPECT_TRUE(edges.emplace(f[k], f[(k + 1) % 3]).second) << shape.name;
        for (const glm::u32vec2& e : m.boundary) EXPECT_FALSE(edges.contains({e.y, e.x})) << shape.name;
        expect_one_fan_each(m, shape.name);
    }
}

TEST(Manifold, HasTheInputsFacesOnce) {
    for (const NamedMesh& shape : all_shapes()) {
        const pm::Manifold m = pm::make_manifold(shape.mesh.triangles, uint32_t(shape.mesh.positions.size()));
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
        const pm::Manifold m = pm::make_manifold(mesh.triangles, uint32_t(mesh.positions.size()));
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
        const pm::Manifold m = pm::make_manifold(faces, vertices);
        std::set<std::pair<uint32_t, uint32_t>> edges;
        for (const glm::u32vec3& f : m.faces)
            for (int k = 0; k < 3; ++k) EXPECT_TRUE(edges.emplace(f[k], f[(k + 1) % 3]).second);
        expect_one_fan_each(m, "random");
    }
}

}  // namespace
