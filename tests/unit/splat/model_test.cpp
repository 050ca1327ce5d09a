#include "splat/model.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "splat/cut.h"
#include "splat/info.h"
#include "splat/walk.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

uint64_t count_splats(const splat::Model& model) {
    geom::Camera camera;
    camera.eye = model.header().origin + model.header().scale * glm::dvec3(0, 0, 4);
    camera.target = model.header().origin;
    splat::Cut cut(model);
    splat::CutOptions options;
    options.threshold_px = 0;
    options.cull_backfaces = false;
    const size_t tasks = cut.begin(geom::make_view(camera, 64, 64), options);
    uint64_t splats = 0;
    for (size_t t = 0; t < tasks; ++t)
        cut.run(t, [&](const geom::SplatBatch& b) { splats += uint64_t(b.count); });
    return splats;
}

}  // namespace

// However much of the file is there, what is there can be walked, and grows with it.
TEST(Model, IsACoarserModelWhereverTheFileEnds) {
    const Bytes whole = build_bytes(icosphere(3));
    const size_t first_block = splat::kBlocksAt + splat::kMinBlockSize;
    ASSERT_GE(whole.size(), splat::kBlocksAt + 3 * splat::kMinBlockSize);
    uint64_t last_nodes = 0;
    for (size_t size = 0; size <= whole.size(); ++size) {
        const Bytes prefix(whole.begin(), whole.begin() + ptrdiff_t(size));
        if (size < first_block) {
            ASSERT_THROW(open_model(prefix), core::Error) << size;
            continue;
        }
        const splat::Model model = open_model(prefix);
        ASSERT_EQ(model.is_complete(), size == whole.size()) << size;
        const splat::Info info = splat::read_info(model);
        ASSERT_GE(info.nodes_present, last_nodes) << size;
        ASSERT_EQ(info.blocks_present, (size - splat::kBlocksAt) / splat::kMinBlockSize);
        last_nodes = info.nodes_present;
        if (size % 97 == 0) {
            uint64_t cut = 0;  // leaves, and nodes whose children are missing
            splat::walk(model, splat::kMaxLevels,
                        [&](const splat::WalkedNode& n) { cut += n.node.children == 0 || n.lacks_children; });
            ASSERT_EQ(count_splats(model), cut) << size;
        }
    }
    EXPECT_EQ(last_nodes, open_model(whole).header().node_count);
}

TEST(Model, RefusesBytesBehindItsEnd) {
    Bytes bytes = build_bytes(tetrahedron());
    bytes.push_back(std::byte{0});
    EXPECT_THROW(open_model(bytes), core::Error);
}

TEST(Model, RefusesABlockWhenItIsUsed) {
    Bytes bytes = build_bytes(icosphere(3));
    bytes[splat::kBlocksAt + splat::kMinBlockSize + 100] ^= std::byte{1};
    const splat::Model model = open_model(bytes);
    EXPECT_NO_THROW(model.block(0));
    try {
        model.block(1);
        FAIL();
    } catch (const core::Error& error) {
        EXPECT_NE(std::string(error.what()).find(": block 1 at byte 2048: checksum "), std::string::npos)
            << error.what();
    }
}

TEST(Model, EveryGroupIsWhereBlocksSay) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    uint64_t nodes = 0;
    uint32_t level = 1;
    splat::GroupAt last;
    splat::walk(model, splat::kMaxLevels, [&](const splat::WalkedNode& n) {
        ASSERT_TRUE(nodes++ == 0 || n.at.block > last.block || n.at.slot > last.slot);
        ASSERT_GE(n.level, level);
        last = n.at, level = n.level;
        ASSERT_FALSE(n.lacks_children);
    });
    EXPECT_EQ(nodes, model.header().node_count);
    EXPECT_EQ(level, model.header().level_count);
}

TEST(Model, BoundsComeFromTheHeader) {
    const splat::Header h = build_model(shifted(icosphere(2), {100, 200, 300})).header();
    EXPECT_NEAR(glm::length(h.origin - glm::dvec3(100, 200, 300)), 0, 1e-6);
    EXPECT_NEAR(h.scale, 1, 0.01);
}
