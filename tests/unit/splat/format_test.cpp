#include "splat/format.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/parallel.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

splat::Header some_header() {
    splat::Header h;
    h.block_size = 4096;
    h.flags = splat::kHasColour | splat::kOpenSurface;
    h.origin = {1e7, -2.5, 1e-30};
    h.scale = 12.75;
    h.block_count = 9;
    h.node_count = 5000;
    h.leaf_count = 4000;
    h.vertices_in = 4100;
    h.triangles_in = 8000;
    h.level_count = 7;
    h.root_children = 5;
    h.root_normal = {0, 0.6f, 0.8f};
    h.root_flatness = 0.5f;
    h.root_error = 1.25f;
    h.root_cone = 2;
    h.colour = {1, 2, 3, 0};
    return h;
}

std::string refusal(std::span<const std::byte> bytes) {
    try {
        splat::parse_header(bytes, "m.qs");
        return "";
    } catch (const core::Error& error) {
        return error.what();
    }
}

template <class Change>
std::string refusal_after(const Change& change) {
    splat::Header h = some_header();
    change(h);
    return refusal(splat::encode_header(h));
}

Bytes some_bytes() {
    const auto header = splat::encode_header(some_header());
    return Bytes(header.begin(), header.end());
}

}  // namespace

TEST(QsHeader, ReadsBackWhatWasWritten) {
    const splat::Header a = some_header();
    const auto bytes = splat::encode_header(a);
    const splat::Header b = splat::parse_header(bytes, "m.qs");
    EXPECT_EQ(splat::encode_header(b), bytes);
    EXPECT_EQ(b.origin, a.origin);
    EXPECT_EQ(b.scale, a.scale);
    EXPECT_EQ(b.node_count, a.node_count);
    EXPECT_EQ(b.root_cone, a.root_cone);
    EXPECT_EQ(b.colour, a.colour);
}

TEST(QsHeader, RefusesWhatCannotBe) {
    EXPECT_EQ(refusal(some_bytes()), "");
    using H = splat::Header;
    EXPECT_EQ(refusal_after([](H& h) { h.block_size = 3000; }),
              "m.qs: header: block size 3000 is not a power of two from 1024 to 65536");
    EXPECT_NE(refusal_after([](H& h) { h.block_size = 512; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.block_size = 131072; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.block_count = 0; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.block_count = uint64_t(1) << 60; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.node_count = uint64_t(1) << 40; }), "")
        << "more nodes than the blocks can hold";
    EXPECT_NE(refusal_after([](H& h) { h.node_count = 4; }), "") << "fewer nodes than the root has children";
    EXPECT_NE(refusal_after([](H& h) { h.leaf_count = 5001; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.leaf_count = 0; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.level_count = 0; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.level_count = 4097; }), "");
    EXPECT_EQ(refusal_after([](H& h) { h.flags |= splat::kConstantColour; }),
              "m.qs: header: one colour for all, and one for each node");
    EXPECT_NE(refusal_after([](H& h) { h.root_children = 0; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.root_children = 8; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.origin.y = std::nan(""); }), "");
    EXPECT_NE(refusal_after([](H& h) { h.scale = 0; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.scale = -1; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.scale = INFINITY; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.root_normal = {0, 0, 0.5f}; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.root_normal.x = std::nanf(""); }), "");
    EXPECT_NE(refusal_after([](H& h) { h.root_flatness = 0; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.root_error = 2.5f; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.root_cone = 8; }), "");
    EXPECT_NE(refusal_after([](H& h) { h.root_cone = -2; }), "");
}

TEST(QsHeader, RefusesEveryFlippedBit) {
    auto bytes = splat::encode_header(some_header());
    for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
        EXPECT_THROW(splat::parse_header(bytes, "m.qs"), core::Error) << bit;
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
    }
    EXPECT_NO_THROW(splat::parse_header(bytes, "m.qs"));
}

TEST(QsHeader, RefusesBlocksElsewhere) {
    Bytes bytes = some_bytes();
    bytes[13] = std::byte{1};
    repair_header(bytes);
    EXPECT_EQ(refusal(bytes),
              "m.qs: header: blocks from byte 256 on, version 1 has them from 1024 on; build the model again "
              "with qs-build");
}

TEST(QsHeader, RefusesAGapThatIsNotEmptyAsFarAsItIsThere) {
    for (size_t at = splat::kHeaderSize; at < splat::kBlocksAt; ++at) {
        Bytes bytes = some_bytes();
        bytes.resize(at);
        EXPECT_EQ(refusal(bytes), "");
        bytes.push_back(std::byte{1});
        EXPECT_EQ(refusal(bytes),
                  core::text("m.qs: header: byte %zu is not 0, as all before the blocks are", at));
    }
    Bytes bytes = some_bytes();
    bytes.resize(splat::kBlocksAt);
    bytes.push_back(std::byte{1});
    EXPECT_EQ(refusal(bytes), "") << "a block's";
}

TEST(QsHeader, NamesTheOriginalProgramsFiles) {
    Bytes bytes(300);
    std::memcpy(bytes.data(), "QSplat11", 8);
    try {
        splat::parse_header(bytes, "old.qs");
        FAIL();
    } catch (const core::Error& error) {
        EXPECT_NE(std::string(error.what()).find("original QSplat"), std::string::npos);
    }
}

TEST(QsBlock, ChannelsFitAndDoNotOverlap) {
    for (uint32_t size = splat::kMinBlockSize; size <= splat::kMaxBlockSize; size *= 2)
        for (const uint32_t flags : {0u, uint32_t(splat::kHasColour)}) {
            splat::Header h = some_header();
            h.block_size = size, h.flags = flags;
            const splat::BlockLayout l(h);
            EXPECT_EQ(l.capacity % 7, 0u);
            EXPECT_EQ(l.attitude, 16u);
            EXPECT_EQ(l.place, l.attitude + 2 * l.capacity);
            EXPECT_EQ(l.colour, l.place + 2 * l.capacity);
            EXPECT_EQ(l.shape, l.colour + (flags ? 2 * l.capacity : 0));
            EXPECT_LE(l.shape + (l.capacity + 1) / 2, size);
        }
}

TEST(QsBlock, ChecksumKnowsTheBlocksPlace) {
    const Bytes block(1024, std::byte{7});
    EXPECT_NE(splat::block_checksum(block, 0), splat::block_checksum(block, 1)) << "swapped blocks are found";
}

// Order of work must not show: more than one subtree, colours, an open surface, a cloud.
TEST(Build, ThreadsDoNotChangeAByte) {
    const mesh::Mesh meshes[] = {bumpy_torus(90, 200, true), terrain(100), cloud(20000),
                                 shared_mesh("bunny.ply")};
    for (const mesh::Mesh& mesh : meshes) {
        if (mesh.positions.empty()) continue;  // the real one is not there
        Bytes first;
        for (const int threads : {1, 2, 16}) {
            core::set_thread_count(threads);
            const Bytes bytes = build_bytes(mesh);
            if (first.empty()) first = bytes;
            EXPECT_TRUE(bytes == first) << threads << " threads, " << mesh.positions.size() << " vertices";
        }
        core::set_thread_count(0);
    }
}

TEST(Build, StoresOrDropsEveryVertex) {
    for (NamedMesh& m : generated_meshes()) {
        mesh::Mesh mesh = m.mesh;
        for (int i = 0; i < 5; ++i) mesh.positions.emplace_back(0.1f * float(i), 0, 0);  // no face uses them
        const uint64_t vertices = mesh.positions.size();
        splat::BuildReport report;
        build_bytes(mesh, {}, &report);
        uint64_t dropped = 0;
        for (const auto& [reason, count] : report.vertices_dropped) dropped += count;
        EXPECT_EQ(dropped, 5u) << m.name;
        EXPECT_EQ(report.header.leaf_count + dropped, vertices) << m.name;
        EXPECT_EQ(report.header.vertices_in, vertices) << m.name;
        EXPECT_EQ(report.header.triangles_in, m.mesh.triangles.size()) << m.name;
    }
}
