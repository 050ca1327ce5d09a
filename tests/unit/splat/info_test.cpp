#include "splat/info.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "splat/extract.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

std::string cut_bytes(const splat::Model& model, uint32_t level) {
    const std::string path = testing::TempDir() + "cut-" + std::to_string(::getpid()) + ".ply";
    core::OutputFile out(path);
    splat::write_cut(model, level, out);
    out.commit();
    const Bytes bytes = read_bytes(path);
    std::filesystem::remove(path);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

mesh::Mesh cut_mesh(const splat::Model& model, uint32_t level) {
    const std::string bytes = cut_bytes(model, level);
    return mesh::read_mesh_bytes(std::as_bytes(std::span(bytes)), "cut.ply").mesh;
}

}  // namespace

TEST(Info, ChannelsAddUpToTheFile) {
    for (const bool has_colour : {false, true}) {
        const Bytes bytes = build_bytes(bumpy_torus(60, 160, has_colour));
        const splat::Info info = splat::read_info(open_model(bytes));
        uint64_t sum = 0;
        for (const splat::ChannelInfo& c : info.channels) sum += c.bytes;
        EXPECT_EQ(sum, bytes.size());
        EXPECT_EQ(info.file_bytes, bytes.size());
    }
}

TEST(Info, LevelsAddUpToTheModel) {
    splat::BuildReport report;
    const Bytes bytes = build_bytes(bumpy_torus(60, 160), {}, &report);
    const splat::Info info = splat::read_info(open_model(bytes));
    uint64_t nodes = 0, leaves = 0, last_prefix = 0;
    for (size_t l = 0; l < info.levels.size(); ++l) {
        const splat::LevelInfo& level = info.levels[l];
        if (l > 0) nodes += level.nodes, leaves += level.leaves;
        EXPECT_LE(level.radius_mean, level.radius_max);
        EXPECT_LE(level.error_mean, level.error_max);
        EXPECT_GE(level.prefix_bytes, last_prefix);
        last_prefix = level.prefix_bytes;
    }
    EXPECT_LT(info.levels.back().error_max, 0.1 * info.levels.front().error_max);
    EXPECT_EQ(nodes, info.header.node_count);
    EXPECT_EQ(leaves, info.header.leaf_count);
    EXPECT_EQ(info.inserted, report.fit.inserted);
    EXPECT_EQ(info.levels.size(), info.header.level_count + 1);
    EXPECT_EQ(last_prefix, bytes.size());
}

TEST(Info, PrefixBytesHoldTheLevel) {
    const Bytes bytes = build_bytes(bumpy_torus(60, 160));
    const splat::Info whole = splat::read_info(open_model(bytes));
    for (uint32_t l = 0; l <= whole.header.level_count; ++l) {
        const auto prefix = ptrdiff_t(whole.levels[l].prefix_bytes);
        const splat::Info info = splat::read_info(open_model(Bytes(bytes.begin(), bytes.begin() + prefix)));
        EXPECT_GE(info.levels_complete, l);
        EXPECT_EQ(info.levels[l].nodes, whole.levels[l].nodes);
        EXPECT_EQ(info.levels[l].error_max, whole.levels[l].error_max);
    }
}

TEST(Extract, ACutHasTheLevelAndTheLeavesAboveIt) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    const Tree tree = read_tree(model);
    for (uint32_t level = 0; level <= model.header().level_count; ++level) {
        size_t expected = 0;
        for (size_t i = 0; i < tree.nodes.size(); ++i)
            expected += tree.level[i] == level || (tree.level[i] < level && tree.nodes[i].children == 0);
        EXPECT_EQ(cut_mesh(model, level).positions.size(), expected) << level;
    }
    EXPECT_EQ(cut_mesh(model, model.header().level_count).positions.size(), model.header().leaf_count);
    EXPECT_THROW(cut_bytes(model, model.header().level_count + 1), core::Error);
}

TEST(Extract, PointsAreWhereTheNodesAre) {
    const glm::dvec3 far(4e5, 5e6, 100);
    for (const glm::dvec3& by : {glm::dvec3(0), far}) {
        const splat::Model model = build_model(shifted(bumpy_torus(20, 30, true), by));
        const splat::Header& h = model.header();
        const Tree tree = read_tree(model);
        const mesh::Mesh cut = cut_mesh(model, 1);
        ASSERT_EQ(cut.positions.size(), h.root_children);
        ASSERT_EQ(cut.colours.size(), h.root_children);
        for (size_t i = 0; i < cut.positions.size(); ++i) {
            const splat::Node& node = tree.nodes[i + 1];
            EXPECT_LT(glm::length(cut.world(i) - (h.origin + h.scale * node.centre)), 2e-6 * h.scale);
            EXPECT_LT(glm::length(cut.normals[i] - node.normal), 1e-5f);
            EXPECT_EQ(cut.colours[i], splat::decode_colour(node.colour));
        }
        EXPECT_EQ(cut_bytes(model, 1).find("property double x") != std::string::npos, by != glm::dvec3(0));
    }
}

TEST(Extract, ACutOfAPrefixStandsForTheWholeSurface) {
    Bytes bytes = build_bytes(bumpy_torus(60, 160));
    bytes.resize(splat::kBlocksAt + 3 * splat::kMinBlockSize);
    const splat::Model model = open_model(bytes);
    const Tree tree = read_tree(model);
    std::vector<bool> has_child(tree.nodes.size(), false);
    for (size_t i = 1; i < tree.nodes.size(); ++i) has_child[tree.parent[i]] = true;
    const auto front = size_t(std::count(has_child.begin(), has_child.end(), false));
    EXPECT_EQ(cut_mesh(model, model.header().level_count).positions.size(), front);
}
