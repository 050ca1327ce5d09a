#include "pm/model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pm/extract.h"
#include "pm/info.h"
#include "pm/selection.h"
#include "pm/verify.h"
#include "test_models.h"

namespace {

using namespace pm_test;

template <class T>
Bytes with(Bytes bytes, uint64_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof(T));
    return repaired(std::move(bytes));
}

const auto kOpen = [](const pm::Model&) {};

struct Fixture {
    Bytes bytes = build_bytes(splat_test::bumpy_torus(12, 30, true));
    pm::Header header = pm::parse_header(bytes, "model");
    pm::Layout layout{header};
};

TEST(Model, IsRefusedWhereverItIsCutOff) {
    const Bytes whole = build_bytes(splat_test::icosphere(1));
    for (size_t size = 0; size < whole.size(); ++size) {
        const Bytes part(whole.begin(), whole.begin() + ptrdiff_t(size));
        EXPECT_NE(fault_of(part, kOpen), "") << size;
        EXPECT_NE(fault_of(repaired(part), kOpen), "") << size;
    }
    Bytes longer = whole;
    longer.push_back(std::byte{0});
    EXPECT_EQ(fault_of(longer, kOpen), "1 bytes behind its end");
}

TEST(Model, NamesWhatIsWrongInTheHeader) {
    const Fixture f;
    EXPECT_EQ(fault_of(with(f.bytes, 8, uint32_t(2)), kOpen),
              "format version 2, this program reads version 1");
    EXPECT_EQ(fault_of(with(f.bytes, 12, uint32_t(200)), kOpen), "header: size 200, version 1 has 192");
    EXPECT_EQ(fault_of(with(f.bytes, 16, uint32_t(8)), kOpen), "header: unknown flags 00000008");
    EXPECT_EQ(fault_of(with(f.bytes, 20, uint32_t(25)), kOpen),
              "header: 25 bits a coordinate, 4 to 24 are possible, or 0");
    EXPECT_EQ(fault_of(with(f.bytes, 24, uint32_t(0)), kOpen), "header: the base mesh has no vertices");
    EXPECT_EQ(fault_of(with(f.bytes, 44, uint32_t(1)), kOpen), "header: what is reserved is not 0");
    EXPECT_EQ(fault_of(with(f.bytes, 72, std::nan("")), kOpen), "header: the origin is not finite");
    EXPECT_EQ(fault_of(with(f.bytes, 120, 0.0), kOpen), "header: the extent is not a positive number");
    EXPECT_EQ(fault_of(with(f.bytes, 150, uint8_t(1)), kOpen), "header: what is reserved is not 0");
    Bytes bytes = f.bytes;
    bytes[100] ^= std::byte{1};
    EXPECT_TRUE(fault_of(bytes, kOpen).starts_with("header: checksum "));
}

// Counts that no file could have: refused by the file's size, before anything is allocated or read.
TEST(Model, RefusesCountsBeyondTheFile) {
    const Fixture f;
    for (const uint64_t at : {24, 28, 32, 36})
        for (const uint32_t count : {0x7ffffffeu, 0x80000000u, 0xffffffffu})
            EXPECT_NE(fault_of(with(f.bytes, at, count), kOpen), "") << at;
    EXPECT_NE(fault_of(with(f.bytes, 48, ~uint64_t(0)), kOpen), "");
}

TEST(Model, NamesAReferenceThatIsOutOfRangeOrLeadsInCircles) {
    const Fixture f;
    const uint32_t d = f.header.details / 2;
    const auto fault = [&](uint64_t section, uint32_t value, uint64_t index, uint64_t width = 4) {
        return fault_of(with(f.bytes, section + width * index, value), kOpen);
    };
    const std::string detail = "detail " + std::to_string(d);
    uint32_t parent;
    std::memcpy(&parent, f.bytes.data() + f.layout.parent + 4 * d, 4);
    ASSERT_NE(parent, pm::kNone);
    // The parent stands before it, and is asked first.
    const std::string at_parent = "detail " + std::to_string(parent) + " has a child that does not know it";
    EXPECT_EQ(fault(f.layout.base_faces, pm::kNone, 0), "base face 0 has a corner that is not there");
    EXPECT_EQ(fault(f.layout.kept, f.header.base_vertices + d, d), at_parent);
    EXPECT_EQ(fault(f.layout.parent, d, d), at_parent);
    EXPECT_EQ(fault(f.layout.parent, d + 1, d), at_parent);
    EXPECT_EQ(fault(f.layout.parent, pm::kNone, d), at_parent);
    EXPECT_EQ(fault(f.layout.needs, d, d), detail + " needs a detail that is not before it");
    EXPECT_EQ(fault(f.layout.children, f.header.details, d, 8),
              detail + " has a child that does not know it");
    EXPECT_EQ(fault(f.layout.children, 0, d, 8), detail + " has a child that does not know it");
    EXPECT_EQ(fault(f.layout.faces, uint32_t(f.header.vertices()), d, 24),
              detail + " adds a face with a corner that is not there");
    EXPECT_EQ(fault_of(with(f.bytes, f.layout.axis + 2 * d, uint16_t(pm::kAxisCodes)), kOpen),
              detail + " has a bound that is not in its range");
    EXPECT_EQ(fault_of(with(f.bytes, f.layout.angle + d, uint8_t(32)), kOpen),
              detail + " has a bound that is not in its range");
    EXPECT_EQ(fault_of(with(f.bytes, f.layout.radius + d, uint8_t(64)), kOpen),
              detail + " has a bound that is not in its range");
    EXPECT_EQ(fault_of(with(f.bytes, f.layout.error + d, uint8_t(255)), kOpen),
              detail + " has a larger error than the one before it");
    EXPECT_EQ(fault_of(with(f.bytes, f.layout.positions + 6 * d, uint16_t(0x4000)), kOpen),
              "vertex " + std::to_string(d) + " is not on the lattice");
}

TEST(Model, WithAnyByteChangedIsRefusedOrSafe) {
    const Bytes whole = build_bytes(splat_test::with_duplicates(), lossless());
    Random random(3);
    for (int round = 0; round < 1500; ++round) {
        Bytes bytes = whole;
        for (int n = 1 + int(random.bits() % 3); n > 0; --n)
            bytes[random.bits() % bytes.size()] ^= std::byte(1 + random.bits() % 255);
        fault_of(round % 4 ? repaired(bytes) : bytes, [](const pm::Model& model) {
            pm::Selection(model).select(pm::View{});
            pm::mesh_of_level(model, model.details());
            pm::to_text(pm::read_info(model));
            pm::verify(model);
        });
    }
}

TEST(Model, HasAHashThatChangesWithEveryByte) {
    const Fixture f;
    const uint64_t hash = pm::Model(memory_file(f.bytes)).hash();
    EXPECT_EQ(hash, pm::Model(memory_file(f.bytes)).hash());
    const Bytes changed = with(f.bytes, f.layout.colours, uint8_t(uint8_t(f.bytes[f.layout.colours]) ^ 1));
    EXPECT_NE(hash, pm::Model(memory_file(changed)).hash());
}

TEST(Model, SectionsOfItsInfoAddUp) {
    const pm::Model model = build_model(splat_test::bumpy_torus(12, 30, true));
    const pm::Info info = pm::read_info(model);
    uint64_t sum = 0;
    for (const auto& [name, bytes] : info.sections) sum += bytes;
    EXPECT_EQ(sum, info.file_bytes);
    EXPECT_EQ(info.levels.back().splits, model.details());
    EXPECT_EQ(info.levels.back().faces, model.header().faces);
}

}  // namespace
