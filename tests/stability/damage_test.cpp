// Models with damage: they are refused or drawn in part, and nothing else happens.  Under the address
// sanitizer this also shows that nothing is read outside.
#include <gtest/gtest.h>
#include <xxhash.h>

#include <cstring>
#include <random>

#include "core/error.h"
#include "splat/verify.h"
#include "subject.h"

namespace stability {
namespace {

const std::string& sound_model() {
    static const std::string bytes = build(bumpy_sphere(), Precision::single).bytes;
    return bytes;
}

enum class Outcome { drawn, refused };

// Draws what can be drawn, cut at leaves and roughly.  Anything but core::Error fails the test.
Outcome try_to_draw(const std::string& bytes) {
    try {
        const splat::Model model(nameless_file(bytes));
        scene::ModelPainter painter(model);
        geom::Camera camera;
        camera.eye = model.header().origin + model.header().scale * glm::dvec3(0, 0.5, 4);
        camera.target = model.header().origin;
        const geom::View view = geom::make_view(camera, 100, 80);
        render::Frame frame;
        scene::DrawOptions options = all_detail();
        painter.draw(view, options, frame);
        EXPECT_EQ(bad_pixels(frame), 0u);
        options.cut.threshold_px = 4;
        painter.draw(view, options, frame);
        return Outcome::drawn;
    } catch (const core::Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        return Outcome::refused;
    }
}

bool verifies(const std::string& bytes) {
    try {
        splat::verify(nameless_file(bytes));
        return true;
    } catch (const core::Error&) {
        return false;
    }
}

std::string with_flipped_bit(std::string bytes, size_t bit) {
    bytes[bit / 8] = char(bytes[bit / 8] ^ (1 << bit % 8));
    return bytes;
}

// Checksums made to fit, and the gap behind the header made 0, so that what follows them must stand the
// damage.
void mend_checksums(std::string& bytes) {
    const auto put = [&](size_t at, auto sum) { std::memcpy(bytes.data() + at, &sum, sizeof(sum)); };
    put(splat::kHeaderSize - 8, uint64_t(XXH3_64bits(bytes.data(), splat::kHeaderSize - 8)));
    uint64_t number = 0;
    std::fill_n(bytes.begin() + splat::kHeaderSize, splat::kGap.size(), '\0');
    for (size_t at = splat::kBlocksAt; at + splat::kMinBlockSize <= bytes.size();
         at += splat::kMinBlockSize) {
        const auto block = std::as_bytes(std::span(bytes.data() + at, splat::kMinBlockSize));
        put(at, splat::block_checksum(block, number++));
    }
}

TEST(DamagedModel, IsSoundToBeginWith) {
    EXPECT_EQ(try_to_draw(sound_model()), Outcome::drawn);
    EXPECT_TRUE(verifies(sound_model()));
    std::string mended = sound_model();
    mend_checksums(mended);
    EXPECT_EQ(mended, sound_model());
}

TEST(DamagedModel, EveryFlippedBitBeforeTheBlocksIsRefused) {
    for (size_t bit = 0; bit < 8 * splat::kBlocksAt; bit += bit < 8 * splat::kHeaderSize ? 1 : 7) {
        const std::string bytes = with_flipped_bit(sound_model(), bit);
        EXPECT_EQ(try_to_draw(bytes), Outcome::refused) << "bit " << bit;
        EXPECT_FALSE(verifies(bytes)) << "bit " << bit;
    }
}

TEST(DamagedModel, EveryFlippedBitOfTheBodyIsFound) {
    std::mt19937_64 random(7);
    const size_t first = 8 * splat::kBlocksAt, bits = 8 * sound_model().size() - first;
    for (int i = 0; i < 400; ++i) {
        const size_t bit = first + random() % bits;
        const std::string bytes = with_flipped_bit(sound_model(), bit);
        EXPECT_FALSE(verifies(bytes)) << "bit " << bit;
        try_to_draw(bytes);
    }
}

TEST(DamagedModel, WithChecksumsThatFitIsDrawnOrRefused) {
    std::mt19937_64 random(11);
    for (int i = 0; i < 600; ++i) {
        std::string bytes = sound_model();
        for (int flips = 0; flips < 1 + i % 8; ++flips)
            bytes = with_flipped_bit(bytes, random() % (8 * bytes.size()));
        mend_checksums(bytes);
        try_to_draw(bytes);
        verifies(bytes);
    }
}

TEST(DamagedModel, HeaderFieldsThatLieAreDrawnOrRefused) {
    // From the block size to the colour.
    for (size_t at = 16; at < 136; at += 4)
        for (const uint32_t value :
             {0u, 1u, 7u, 0x7fffffffu, 0x80000000u, 0xffffffffu, 0x7fc00000u, 0x7ff00000u}) {
            std::string bytes = sound_model();
            std::memcpy(bytes.data() + at, &value, sizeof(value));
            mend_checksums(bytes);
            try_to_draw(bytes);
            verifies(bytes);
        }
}

TEST(DamagedModel, BlockHeadersThatLieAreDrawnOrRefused) {
    const size_t blocks = (sound_model().size() - splat::kBlocksAt) / splat::kMinBlockSize;
    for (size_t block = 0; block < blocks; ++block)
        for (size_t at = 4; at < sizeof(splat::BlockHeader); at += 2)
            for (const unsigned lie : {0u, 1u, 6u, 7u, 0x7fffu, 0xffffu}) {
                const auto value = uint16_t(lie);
                std::string bytes = sound_model();
                std::memcpy(bytes.data() + splat::kBlocksAt + block * splat::kMinBlockSize + at, &value,
                            sizeof(value));
                const bool is_changed = bytes != sound_model();
                mend_checksums(bytes);
                try_to_draw(bytes);
                EXPECT_EQ(verifies(bytes), !is_changed)
                    << "block " << block << " byte " << at << ": " << value;
            }
}

TEST(DamagedModel, CutOffAnywhereIsACoarserModelOrRefused) {
    const size_t first = splat::kBlocksAt + splat::kMinBlockSize, size = sound_model().size();
    for (size_t length = 0; length < size; length += length < first + 64 ? 1 : 61) {
        const std::string bytes = sound_model().substr(0, length);
        EXPECT_EQ(try_to_draw(bytes), length < first ? Outcome::refused : Outcome::drawn)
            << length << " bytes";
        EXPECT_FALSE(verifies(bytes)) << length << " bytes";
    }
}

TEST(DamagedModel, WithBytesAfterItsEndIsRefused) {
    EXPECT_EQ(try_to_draw(sound_model() + '\0'), Outcome::refused);
    EXPECT_EQ(try_to_draw(sound_model() + sound_model()), Outcome::refused);
}

TEST(DamagedModel, OfNoiseIsRefused) {
    std::mt19937_64 random(13);
    for (int i = 0; i < 200; ++i) {
        std::string bytes(random() % 4096, '\0');
        for (char& c : bytes) c = char(random());
        if (i % 2 == 1) bytes.replace(0, 8, "qs-model");
        EXPECT_EQ(try_to_draw(bytes), Outcome::refused);
    }
}

}  // namespace
}  // namespace stability
