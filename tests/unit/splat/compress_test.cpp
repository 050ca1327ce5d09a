#include "splat/compress.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <thread>

#include "core/error.h"
#include "core/parallel.h"
#include "splat/coding/block_index.h"
#include "splat/coding/coded_file.h"
#include "splat/coding/run_codec.h"
#include "splat/info.h"
#include "splat/verify.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

template <class Write>
Bytes bytes_of(const Write& write) {
    core::OutputFile out(core::OutputFile::InMemory{"out"});
    write(out);
    const core::InputFile file = out.read_back();
    return {file.bytes().begin(), file.bytes().end()};
}

Bytes plain_again(const Bytes& coded) {
    const splat::Model model(memory_file(coded));
    return bytes_of([&](core::OutputFile& out) { splat::write_plain(splat::plain_of(model), out); });
}

// "" where the model is whole.
std::string fault_of(const Bytes& bytes) {
    try {
        splat::verify(memory_file(bytes));
        return "";
    } catch (const core::Error& error) {
        return error.what();
    }
}

Bytes prefix(const Bytes& bytes, size_t size) {
    return {bytes.begin(), bytes.begin() + std::ptrdiff_t(size)};
}

constexpr splat::BuildOptions kTriangleLeaves{.leaf = splat::Leaf::triangle};

// Several index pages, with the level above.
const Bytes& large_model() {
    static const Bytes bytes = build_bytes(terrain(320));
    return bytes;
}

}  // namespace

TEST(Compress, GivesBackEveryModelBitForBit) {
    for (const NamedMesh& m : generated_meshes()) {
        const Bytes plain = build_bytes(m.mesh), coded = compressed(plain);
        EXPECT_EQ(plain_again(coded), plain) << m.name;
        EXPECT_EQ(fault_of(coded), "") << m.name;
    }
    for (uint32_t size = 1024; size <= 65536; size *= 4)
        for (const bool has_colour : {false, true}) {
            const Bytes plain = build_bytes(bumpy_torus(60, 160, has_colour), {.block_size = size});
            EXPECT_EQ(plain_again(compressed(plain)), plain) << size;
        }
    EXPECT_EQ(plain_again(compressed(build_bytes(cloud(3000)))), build_bytes(cloud(3000)));
}

// Runs that go on from block to block, or fill few of them; smooth, flat and both; of any size of corners'
// differences; of the largest blocks.
TEST(Compress, GivesBackBlocksOfTriangles) {
    for (const NamedMesh& m : generated_meshes()) {
        const Bytes plain = build_bytes(m.mesh, kTriangleLeaves), coded = compressed(plain);
        EXPECT_EQ(plain_again(coded), plain) << m.name;
        EXPECT_EQ(fault_of(coded), "") << m.name;
    }
    for (uint32_t size = 1024; size <= 65536; size *= 4) {
        splat::BuildOptions options = kTriangleLeaves;
        options.block_size = size;
        const Bytes plain = build_bytes(bumpy_torus(60, 160), options);
        EXPECT_EQ(plain_again(compressed(plain)), plain) << size;
    }
}

TEST(Compress, BlocksOfTrianglesAreSmallerEach) {
    const Bytes plain = build_bytes(bumpy_torus(80, 240), kTriangleLeaves), coded = compressed(plain);
    const splat::CodedFile file(coded, "coded");
    const splat::Header& h = file.header();
    ASSERT_GT(h.triangle_blocks, 50u);
    uint64_t bytes = 0;
    for (uint64_t b = h.node_blocks(); b < h.block_count; ++b) bytes += file.place_of(b).size;
    EXPECT_LT(bytes, h.triangle_blocks * h.block_size * 19 / 20);
}

// The runs of a model's blocks of triangles, one block after the other.
std::vector<splat::PlainRuns> runs_of(const splat::Header& h, const splat::RunCodec& codec,
                                      const Bytes& plain) {
    std::vector<splat::PlainRuns> runs;
    splat::RunPlace place;
    const auto block_at = [&](uint64_t b) {
        if (b == h.block_count) return std::span<const std::byte>();
        return std::span(plain).subspan(h.block_at(b), h.block_size);
    };
    for (uint64_t b = h.node_blocks(); b < h.block_count; ++b) {
        runs.push_back({block_at(b), place});
        place = codec.end_of(runs.back(), block_at(b + 1));
    }
    return runs;
}

// None has to be stored as it is because it would not come back.  A block ends with a part of a step, and
// what a decoder has ahead behind a long step does not reach for it.
TEST(RunCodec, BlocksWithStepsOfAnyLengthComeBack) {
    Random random(9);
    for (const double roughness : {0.02, 0.3, 3.0, 50.0}) {
        mesh::Mesh rough = terrain(100);
        for (glm::vec3& p : rough.positions)
            p += glm::vec3(roughness * glm::dvec3(random.unit(), random.unit(), random.unit()));
        const Bytes plain = build_bytes(rough, kTriangleLeaves);
        const splat::Header h = splat::parse_header(plain, "plain");
        const splat::RunCodec codec(h);
        const std::vector<splat::PlainRuns> runs = runs_of(h, codec, plain);
        ASSERT_GT(runs.size(), 50u);
        splat::SymbolCounts counts = splat::no_symbols();
        for (const splat::PlainRuns& r : runs)
            if (codec.can_code(r)) codec.count(r, counts);
        const splat::SymbolShares shares =
            splat::decode_tables(splat::encode_tables(counts, splat::kSymbolKinds), splat::kSymbolKinds, "");
        const auto encoding = std::make_unique<splat::EncodingTables>(shares);
        const auto decoding = std::make_unique<splat::DecodingTables>(shares);
        size_t coded = 0;
        for (size_t i = 0; i < runs.size(); ++i) {
            if (!codec.can_code(runs[i])) continue;
            ++coded;
            Bytes again(h.block_size);
            EXPECT_TRUE(codec.decode(codec.encode(runs[i], *encoding), *decoding, again)) << i;
            EXPECT_TRUE(std::equal(again.begin(), again.end(), runs[i].bytes.begin())) << i;
        }
        EXPECT_GT(coded, runs.size() * 9 / 10);
    }
}

// Each alone: no other block is asked for.
TEST(Compress, BlocksOfTrianglesAreDecodedInAnyOrder) {
    const Bytes plain = build_bytes(bumpy_torus(60, 160), kTriangleLeaves), coded = compressed(plain);
    const splat::CodedFile file(coded, "coded");
    const splat::Header& h = file.header();
    for (uint64_t b = h.block_count; b-- > h.node_blocks();) {
        Bytes block(h.block_size);
        file.read(b, block);
        ASSERT_TRUE(std::equal(block.begin(), block.end(), plain.begin() + std::ptrdiff_t(h.block_at(b))))
            << b;
    }
}

TEST(Compress, KeepsRunsThatItDoesNotUnderstand) {
    Bytes plain = build_bytes(bumpy_torus(60, 160), kTriangleLeaves);
    const splat::Header h = splat::parse_header(plain, "plain");
    Random random(5);
    for (uint64_t b = h.node_blocks() + 2; b < h.block_count; ++b)
        for (size_t i = 4; i < h.block_size; ++i)
            plain[h.block_at(b) + i] = std::byte(uint8_t(random.bits()));
    repair_checksums(plain);
    EXPECT_EQ(plain_again(compressed(plain)), plain);
}

TEST(Compress, IsSmaller) {
    EXPECT_LT(compressed(large_model()).size(), large_model().size() * 4 / 5);
}

TEST(Compress, FromAMeshIsFromTheModel) {
    const mesh::Mesh mesh = bumpy_torus(60, 160, true);
    splat::BuildReport report;
    const Bytes coded = build_bytes(mesh, {.compress = true}, &report);
    EXPECT_EQ(coded, compressed(build_bytes(mesh)));
    EXPECT_EQ(report.file_bytes, coded.size());
    uint64_t sum = 0;
    for (const splat::ChannelInfo& c : report.channels) sum += c.bytes;
    EXPECT_EQ(sum, coded.size());
}

TEST(Compress, IsTheSameForAnyThreadCount) {
    core::set_thread_count(1);
    const Bytes one = compressed(large_model());
    core::set_thread_count(16);
    const Bytes many = compressed(large_model());
    core::set_thread_count(0);
    EXPECT_EQ(one, many);
}

TEST(Compress, KeepsBytesOfTheHeaderThatItDoesNotKnow) {
    Bytes plain = build_bytes(bumpy_torus(16, 40));
    plain[200] = std::byte{0x5a};  // reserved
    repair_checksums(plain);
    EXPECT_EQ(plain_again(compressed(plain)), plain);
}

// What is not as builders write it, such as blocks of another kind, is stored as it is.
TEST(Compress, KeepsBlocksThatItDoesNotUnderstand) {
    Bytes plain = build_bytes(bumpy_torus(60, 160));
    const size_t block = splat::kBlocksAt + 3 * splat::kMinBlockSize;
    for (size_t i = 16; i < splat::kMinBlockSize; ++i) plain[block + i] = std::byte(uint8_t(i * 37));
    repair_checksums(plain);
    EXPECT_EQ(plain_again(compressed(plain)), plain);
}

TEST(Compress, ReadsFromAnyThread) {
    const splat::Model model(memory_file(compressed(large_model()))), plain(memory_file(large_model()));
    std::atomic<int> differences = 0;
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (uint64_t b = 0; b < model.blocks_present(); ++b) {
                const auto a = model.block(b), c = plain.block(b);
                differences += !std::equal(a.begin(), a.end(), c.begin());
            }
        });
    threads.clear();
    EXPECT_EQ(differences, 0);
    EXPECT_EQ(model.blocks_used(), model.blocks_present());
}

TEST(Compress, AnyPrefixIsACoarserModel) {
    const Bytes plain = build_bytes(bumpy_torus(40, 60)), coded = compressed(plain);
    const splat::Model whole(memory_file(coded));
    const uint64_t first = whole.prefix_bytes(0);
    uint64_t present = 0;
    for (size_t size = 0; size < coded.size(); ++size) {
        const Bytes cut = prefix(coded, size);
        if (size < first) {
            EXPECT_THROW(splat::Model(memory_file(cut)), core::Error) << size;
            continue;
        }
        const splat::Model model(memory_file(cut));
        while (present < whole.blocks_present() && whole.prefix_bytes(present) <= size) ++present;
        ASSERT_EQ(model.blocks_present(), present) << size;
        const auto last = model.block(present - 1), same = whole.block(present - 1);
        ASSERT_TRUE(std::equal(last.begin(), last.end(), same.begin())) << size;
    }
    Bytes longer = coded;
    longer.push_back(std::byte{0});
    EXPECT_NE(fault_of(longer), "");
}

TEST(Compress, PrefixesOfManyPagesHaveTheirBlocks) {
    const Bytes coded = compressed(large_model());
    const splat::Model whole(memory_file(coded));
    ASSERT_GT(whole.blocks_present(), 2 * splat::kPageEntries);
    for (const uint64_t block :
         {uint64_t(0), uint64_t(254), uint64_t(255), uint64_t(256), uint64_t(511), uint64_t(513)}) {
        const size_t end = whole.prefix_bytes(block);
        EXPECT_EQ(splat::Model(memory_file(prefix(coded, end))).blocks_present(), block + 1);
        if (block == 0) continue;
        EXPECT_EQ(splat::Model(memory_file(prefix(coded, end - 1))).blocks_present(), block);
    }
}

// The header, the first pages and blocks enough for a picture are what two round trips can carry.
TEST(Compress, FirstPictureIsInTheFirst13KiB) {
    const Bytes coded = compressed(large_model());
    EXPECT_GE(splat::Model(memory_file(prefix(coded, 13 * 1024))).blocks_present(), 8u);
}

// Every seventh bit: all eight of a byte come in turn, in a seventh of the time.
TEST(Compress, EveryFlippedBitIsAnErrorOrHarmless) {
    const Bytes plain = build_bytes(bumpy_torus(16, 40, true)), coded = compressed(plain);
    for (size_t bit = 0; bit < 8 * coded.size(); ++bit) {
        Bytes bytes = coded;
        bytes[bit / 8] ^= std::byte(uint8_t(1 << bit % 8));
        if (fault_of(bytes).empty()) {
            ASSERT_EQ(plain_again(bytes), plain) << "bit " << bit;
        }
    }
}

TEST(Compress, EveryFlippedBitOfTrianglesIsAnErrorOrHarmless) {
    const Bytes plain = build_bytes(bumpy_torus(12, 30), kTriangleLeaves), coded = compressed(plain);
    const splat::CodedFile file(coded, "coded");
    const uint64_t begin = file.place_of(file.header().node_blocks()).offset;
    for (size_t bit = 8 * begin; bit < 8 * coded.size(); bit += 3) {
        Bytes bytes = coded;
        bytes[bit / 8] ^= std::byte(uint8_t(1 << bit % 8));
        if (fault_of(bytes).empty()) {
            ASSERT_EQ(plain_again(bytes), plain) << "bit " << bit;
        }
    }
}

TEST(Compress, CountsThatTheFileHasNoRoomForAreRefused) {
    Bytes coded = compressed(build_bytes(bumpy_torus(16, 40)));
    const uint64_t blocks = uint64_t(1) << 30, nodes = blocks;
    std::memcpy(coded.data() + splat::kCodedHeaderSize + 56, &blocks, 8);
    std::memcpy(coded.data() + splat::kCodedHeaderSize + 64, &nodes, 8);
    repair_checksums(coded);
    EXPECT_NE(fault_of(coded).find("do not go with a file of"), std::string::npos) << fault_of(coded);
}

TEST(Compress, ChannelsAddUpToTheFile) {
    const Bytes coded = compressed(large_model());
    const splat::Info info = splat::read_info(splat::Model(memory_file(coded)));
    EXPECT_TRUE(info.is_compressed);
    EXPECT_EQ(info.plain_bytes, large_model().size());
    uint64_t sum = 0;
    for (const splat::ChannelInfo& c : info.channels) sum += c.bytes;
    EXPECT_EQ(sum, coded.size());
}

TEST(BlockIndex, HasAsManyLevelsAsItNeeds) {
    const splat::BlockIndex index(uint64_t(3) << 24);
    EXPECT_EQ(index.levels(), 4u);
    EXPECT_EQ(index.pages(0), uint64_t(3) << 16);
    EXPECT_EQ(index.entries(3, 0), 3u);
    EXPECT_EQ(index.page_bytes(0, 0), 4 + 2 * 256u);
    EXPECT_EQ(splat::BlockIndex(1).levels(), 1u);
    EXPECT_EQ(splat::BlockIndex(256).levels(), 1u);
    EXPECT_EQ(splat::BlockIndex(257).levels(), 2u);
    EXPECT_EQ(splat::BlockIndex(257).entries(0, 1), 1u);
}
