#include "core/bytes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

namespace {

TEST(Bytes, ReadBackWhatWasWritten) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 100; ++round) {
        const auto a = random();
        const auto b = static_cast<uint8_t>(random());
        const double c = std::bit_cast<double>(random());
        const auto d = static_cast<int16_t>(random());
        core::ByteWriter writer;
        writer.put(a);
        writer.put(b);
        writer.put(c);
        writer.put(d);
        core::ByteReader reader(writer.bytes, "test");
        EXPECT_EQ(reader.take<uint64_t>(), a);
        EXPECT_EQ(reader.take<uint8_t>(), b);
        EXPECT_EQ(std::bit_cast<uint64_t>(reader.take<double>()), std::bit_cast<uint64_t>(c));
        EXPECT_EQ(reader.take<int16_t>(), d);
        EXPECT_EQ(reader.position(), writer.bytes.size());
    }
}

TEST(Bytes, LowByteComesFirst) {
    core::ByteWriter writer;
    writer.put(uint32_t{0x04030201});
    for (size_t i = 0; i < 4; ++i) EXPECT_EQ(writer.bytes[i], static_cast<std::byte>(i + 1));
}

TEST(Bytes, CutOffAnywhereIsAnErrorThatSaysWhere) {
    const std::vector<std::byte> bytes(8);
    for (size_t size = 0; size < 8; ++size) {
        core::ByteReader reader(std::span<const std::byte>(bytes.data(), size), "model.qs");
        try {
            reader.take<uint64_t>();
            FAIL() << size << " bytes were enough";
        } catch (const core::Error& error) {
            EXPECT_EQ(error.what(), "model.qs: cut off at byte " + std::to_string(size));
        }
        EXPECT_EQ(reader.position(), 0u);
    }
}

}  // namespace
