// The order of the leaves, by the nodes that come of it.
#include <gtest/gtest.h>

#include "splat/walk.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

void append(mesh::Mesh& to, const mesh::Mesh& what, const glm::vec3& at) {
    const auto first = uint32_t(to.positions.size());
    for (const glm::vec3& position : what.positions) to.positions.push_back(position + at);
    for (const glm::u32vec3& face : what.triangles) to.triangles.push_back(face + first);
}

}  // namespace

// A group that was filled up with leaves from beyond a gap would be as wide as the gap: one on each level,
// and nodes between it and each of its leaves.
TEST(Tree, OnlyNodesAboveAGapAreAsWideAsIt) {
    for (const splat::Leaf leaf : {splat::Leaf::point, splat::Leaf::triangle}) {
        mesh::Mesh mesh;
        const mesh::Mesh ball = icosphere(3);
        for (const glm::vec3& at : {glm::vec3(0, 0, 0), glm::vec3(40, 0, 0), glm::vec3(40, 7, 0)})
            append(mesh, ball, at);
        splat::BuildOptions options;
        options.leaf = leaf;
        const splat::Model model = build_model(mesh, options);
        const double wide = 2.5 / model.header().scale;
        size_t wide_count = 0, count = 0;
        splat::walk(model, model.header().level_count, [&](const splat::WalkedNode& walked) {
            ++count, wide_count += double(walked.node.radius) > wide;
        });
        EXPECT_EQ(count, model.header().node_count);
        // All three, two of them, and what stands between these and a ball.
        EXPECT_GE(wide_count, 2u);
        EXPECT_LE(wide_count, 6u);
    }
}
