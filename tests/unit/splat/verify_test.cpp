#include "splat/verify.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/error.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

std::string fault_of(const Bytes& bytes) {
    try {
        splat::verify(memory_file(bytes));
        return "";
    } catch (const core::Error& error) {
        std::string what = error.what();
        return what.substr(what.find(": ") + 2);  // without the file's name
    }
}

// A model of several blocks, changed, with checksums that say nothing.
template <class Change>
std::string fault_after(const Change& change, bool has_colour = false) {
    Bytes bytes = build_bytes(bumpy_torus(16, 40, has_colour));
    change(bytes);
    repair_checksums(bytes);
    return fault_of(bytes);
}

constexpr size_t kBlock0 = splat::kBlocksAt, kBlock1 = kBlock0 + splat::kMinBlockSize;

template <class T>
void add_at(Bytes& bytes, size_t at, T change) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    value = T(value + change);
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

Bytes tiny() {
    return read_bytes(std::string(QS_TEST_DATA) + "/tiny.qs");
}

}  // namespace

TEST(Verify, AcceptsEveryModel) {
    for (const NamedMesh& m : generated_meshes()) EXPECT_EQ(fault_of(build_bytes(m.mesh)), "") << m.name;
    EXPECT_EQ(fault_of(build_bytes(cloud(3000))), "");
    for (uint32_t size = 1024; size <= 65536; size *= 4) {
        EXPECT_EQ(fault_of(build_bytes(bumpy_torus(60, 160), {.block_size = size})), "");
        EXPECT_EQ(fault_of(build_bytes(bumpy_torus(60, 160, true), {.block_size = size})), "");
    }
}

TEST(Verify, AcceptsRealModels) {
    for (const char* file : {"bunny.ply", "armadillo.ply"}) {
        const mesh::Mesh mesh = shared_mesh(file);
        if (mesh.positions.empty()) GTEST_SKIP() << file << " is not there";
        EXPECT_EQ(fault_of(build_bytes(mesh)), "") << file;
    }
}

TEST(Verify, CountsWhatItFound) {
    const Bytes bytes = build_bytes(bumpy_torus(60, 160));
    const splat::Header h = open_model(bytes).header();
    const splat::VerifyCounts counts = splat::verify(memory_file(bytes));
    EXPECT_EQ(counts.blocks, h.block_count);
    EXPECT_EQ(counts.nodes, h.node_count);
    EXPECT_EQ(counts.leaves, h.leaf_count);
    EXPECT_EQ(counts.levels, h.level_count);
}

TEST(Verify, FindsEveryFlippedBitOfTheHeader) {
    Bytes bytes = tiny();
    ASSERT_EQ(fault_of(bytes), "");
    for (size_t bit = 0; bit < splat::kHeaderSize * 8; ++bit) {
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
        EXPECT_NE(fault_of(bytes), "") << bit;
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
    }
}

TEST(Verify, FindsEverySeventhFlippedBitOfTheGap) {
    Bytes bytes = tiny();
    for (size_t bit = splat::kHeaderSize * 8; bit < kBlock0 * 8; bit += 7) {
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
        EXPECT_TRUE(contains(fault_of(bytes), core::text("header: byte %zu is not 0", bit / 8))) << bit;
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
    }
}

TEST(Verify, FindsEverySeventhFlippedBitOfTheBody) {
    Bytes bytes = tiny();
    for (size_t bit = kBlock0 * 8; bit < bytes.size() * 8; bit += 7) {
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
        EXPECT_TRUE(contains(fault_of(bytes), "block 0 at byte 1024: checksum ")) << bit;
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
    }
}

TEST(Verify, SaysThatACutOffFileIsNotWhole) {
    Bytes bytes = build_bytes(icosphere(3));
    bytes.resize(kBlock1 + 500);
    EXPECT_TRUE(contains(fault_of(bytes), "cut off at byte 2548: 1 of ")) << fault_of(bytes);
}

TEST(Verify, FindsLiesAboutCounts) {
    ASSERT_EQ(fault_after([](Bytes&) {}), "");
    EXPECT_TRUE(
        contains(fault_after([](Bytes& b) { add_at<uint64_t>(b, 64, 1); }), "nodes, its header says "));
    EXPECT_TRUE(contains(fault_after([](Bytes& b) { add_at<uint64_t>(b, 72, uint64_t(-1)); }),
                         "leaves, its header says "));
    EXPECT_TRUE(
        contains(fault_after([](Bytes& b) { add_at<uint32_t>(b, 96, 1); }), "levels, its header says "));
    EXPECT_TRUE(contains(fault_after([](Bytes& b) { add_at<uint32_t>(b, 96, uint32_t(-1)); }),
                         "has nodes with children on level "));
    EXPECT_NE(fault_after([](Bytes& b) { add_at<uint64_t>(b, 56, uint64_t(-1)); }), "") << "blocks";
    EXPECT_TRUE(
        contains(fault_after([](Bytes& b) { add_at<uint64_t>(b, 80, uint64_t(-600)); }), "leaves of "));
    EXPECT_NE(fault_after([](Bytes& b) { add_at<uint32_t>(b, 100, uint32_t(-1)); }), "")
        << "children of the root";
}

TEST(Verify, FindsFlagsThatCannotBe) {
    const auto with = [](uint32_t flags) { return [flags](Bytes& b) { add_at<uint32_t>(b, 20, flags); }; };
    EXPECT_EQ(fault_after(with(1u << 20)), "header: unknown flags 00100000");
    EXPECT_EQ(fault_after(with(splat::kTriangles)), "header: flags 00000010 are not of version 1");
    EXPECT_EQ(fault_after(with(splat::kCloud)), "header: bare points as a closed surface");
    EXPECT_TRUE(
        contains(fault_after(with(splat::kCloud | splat::kOpenSurface)), "header: bare points with "));
    EXPECT_EQ(fault_after(with(splat::kConstantColour), true),
              "header: one colour for all, and one for each node");
}

TEST(Verify, FindsBytesThatShouldBeZero) {
    EXPECT_EQ(fault_after([](Bytes& b) { b[200] = std::byte{1}; }), "header: byte 200 is reserved and not 0");
    EXPECT_TRUE(
        contains(fault_after([](Bytes& b) { b.back() = std::byte{1}; }), ": unused byte 1023 is not 0"));
    const auto in_last_block = [](size_t channel, bool has_colour) {
        return [=](Bytes& b) {
            splat::Header h = splat::parse_header(b, "");
            const splat::BlockLayout l(h);
            const size_t offsets[] = {l.place - 1, l.colour - 1, l.shape - 1,
                                      l.shape + (l.capacity + 1) / 2 - 1};
            ASSERT_EQ(h.has_colour(), has_colour);
            b[kBlock0 + (h.block_count - 1) * h.block_size + offsets[channel]] = std::byte{0x10};
        };
    };
    for (const size_t channel : {0, 1, 3})
        EXPECT_TRUE(contains(fault_after(in_last_block(channel, false)), ": unused ")) << channel;
    for (const size_t channel : {0, 1, 2, 3})
        EXPECT_TRUE(contains(fault_after(in_last_block(channel, true), true), ": unused ")) << channel;
}

TEST(Verify, FindsWrongPointers) {
    const auto shift_slot = [](size_t block) {
        return [=](Bytes& b) { add_at<uint16_t>(b, kBlock0 + block * 1024 + 6, 1); };
    };
    EXPECT_TRUE(contains(fault_after(shift_slot(0)), "block 0 at byte 1024: points to block 0 slot "));
    EXPECT_TRUE(contains(fault_after(shift_slot(1)), "block 1 at byte 2048: points to block "));
    EXPECT_TRUE(contains(fault_after([](Bytes& b) { add_at<uint64_t>(b, kBlock0 + 8, 1); }),
                         "block 0 at byte 1024: points to block 1"));
    EXPECT_TRUE(contains(fault_after([](Bytes& b) { std::memset(&b[kBlock1 + 8], 0, 8); }),
                         "block 1 at byte 2048: points backwards"));
}

TEST(Verify, FindsWrongTrees) {
    // The first node's children: one more, or none.
    EXPECT_NE(fault_after([](Bytes& b) { b[kBlock0 + 16] ^= std::byte{1}; }), "");
    EXPECT_NE(fault_after([](Bytes& b) { b[kBlock0 + 16] &= std::byte{0xf8}; }), "");
    EXPECT_NE(fault_after([](Bytes& b) { add_at<uint16_t>(b, kBlock0 + 4, uint16_t(-1)); }), "");
    EXPECT_TRUE(contains(fault_after([](Bytes& b) { add_at<uint16_t>(b, kBlock0 + 4, 300); }),
                         "block 0 at byte 1024: "));
}

TEST(Verify, FindsCodesThatNoBuilderWrites) {
    EXPECT_TRUE(contains(fault_after([](Bytes& b) {
                             const uint16_t attitude = 1023 << 5;
                             b[kBlock0 + 17] = std::byte(attitude >> 8 | (uint8_t(b[kBlock0 + 17]) & 0x80));
                             b[kBlock0 + 16] |= std::byte(attitude & 0xe0);
                         }),
                         "block 0 at byte 1024: slot 0: normal code 1023, the last is 960"));
}

TEST(Verify, FindsConesThatExcludeEachOther) {
    // The root says that all normals are within 3.2 degrees of its own: no model of a closed surface can.
    EXPECT_TRUE(contains(fault_after([](Bytes& b) { add_at<int32_t>(b, 124, 8); }),
                         "its normal cone lies outside that of the node above"));
}
