#include "splat/level_prefix.h"

#include <gtest/gtest.h>

#include "splat/compress.h"
#include "splat/info.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

// What is fetched of a file until its first levels are known, and how often.
struct Found {
    uint64_t bytes = 0;
    int steps = 0;
};
Found find(const Bytes& file, uint32_t levels, uint64_t bytes) {
    for (int steps = 1;; ++steps) {
        bytes = std::min<uint64_t>(bytes, file.size());
        const splat::Model prefix = open_model(Bytes(file.begin(), file.begin() + ptrdiff_t(bytes)));
        const splat::LevelPrefix found = level_prefix(prefix, levels);
        if (found.is_known || bytes == file.size()) return {found.bytes, steps};
        EXPECT_GT(found.bytes, bytes) << "each step goes on";
        if (found.bytes <= bytes) return {};
        bytes = found.bytes;
    }
}

uint64_t bytes_to_level(const splat::Info& info, uint32_t last) {
    uint64_t bytes = 0;
    for (uint32_t level = 1; level <= last; ++level) bytes = std::max(bytes, info.levels[level].prefix_bytes);
    return bytes;
}

// The sizes and shapes that matter: levels within a block, levels over many, triangles behind them.
std::vector<Bytes> models() {
    std::vector<Bytes> all;
    for (const char* name : {"/bumpy.qs", "/cloud.qs", "/tiny-triangles.qs"})
        all.push_back(read_bytes(QS_TEST_DATA + std::string(name)));
    all.push_back(build_bytes(bumpy_torus(120, 60)));
    all.push_back(build_bytes(mixed_scales()));
    all.push_back(build_bytes(terrain(60), {.leaf = splat::Leaf::triangle}));
    return all;
}

TEST(LevelPrefix, IsWhatTheWholeFileSays) {
    for (const Bytes& bytes : models()) {
        const splat::Info info = read_info(open_model(bytes));
        const uint32_t levels = info.header.level_count;
        for (uint32_t level = 1; level <= levels; ++level) {
            const Found found = find(bytes, level, 2048);
            EXPECT_EQ(found.bytes, bytes_to_level(info, level)) << "level " << level;
            EXPECT_LE(found.steps, int(level) + 6) << "level " << level;
        }
        EXPECT_EQ(find(bytes, 4096, 2048).bytes, bytes_to_level(info, levels));
    }
}

// A guess may be long or short by some blocks; what is found in the end is not.
TEST(LevelPrefix, OfACompressedModelIsFoundToo) {
    for (const Bytes& bytes : models()) {
        const splat::Model plain = open_model(bytes);
        core::OutputFile out(core::OutputFile::InMemory{"coded"});
        splat::write_compressed(splat::plain_of(plain), out);
        const core::InputFile coded = out.read_back();
        const Bytes file(coded.bytes().begin(), coded.bytes().end());
        const splat::Info info = read_info(open_model(file));
        for (uint32_t level = 1; level <= info.header.level_count; ++level)
            EXPECT_EQ(find(file, level, 8192).bytes, bytes_to_level(info, level)) << "level " << level;
    }
}

}  // namespace
