#include "net/frames.h"

#include <gtest/gtest.h>

#include <random>

#include "core/error.h"

namespace {

std::vector<std::byte> body_of(size_t size, unsigned seed) {
    std::vector<std::byte> body(size);
    std::mt19937 random(seed);
    for (std::byte& byte : body) byte = std::byte(random());
    return body;
}

TEST(Frames, ComeOutAsTheyWentInHoweverTheStreamIsCut) {
    std::mt19937 random(1);
    for (int round = 0; round != 50; ++round) {
        std::vector<std::vector<std::byte>> bodies;
        std::vector<std::byte> stream;
        for (unsigned i = 0; i != 20; ++i) {
            bodies.push_back(body_of(1 + random() % (i % 4 == 0 ? 1000 : 5), i));
            const auto frame = net::to_frame(bodies.back());
            stream.insert(stream.end(), frame.begin(), frame.end());
        }
        net::FrameReader reader(1000);
        size_t taken = 0;
        for (size_t at = 0; at != stream.size();) {
            const size_t piece = std::min<size_t>(stream.size() - at, 1 + random() % 300);
            reader.add(std::span(stream).subspan(at, piece));
            at += piece;
            for (auto body = reader.next(); !body.empty(); body = reader.next(), ++taken)
                ASSERT_TRUE(std::equal(body.begin(), body.end(), bodies[taken].begin(), bodies[taken].end()));
        }
        EXPECT_EQ(taken, bodies.size());
        EXPECT_FALSE(reader.is_within());
    }
}

TEST(Frames, OfNoBytesOrTooManyAreRefusedByTheirLengthAlone) {
    for (const uint32_t size : {0u, 1001u, 0x80000000u, 0xffffffffu}) {
        net::FrameReader reader(1000);
        reader.add(std::as_bytes(std::span(&size, 1)).first(3));
        EXPECT_TRUE(reader.next().empty());
        EXPECT_TRUE(reader.is_within());
        reader.add(std::as_bytes(std::span(&size, 1)).last(1));
        EXPECT_THROW(reader.next(), core::Error) << size;
    }
}

}  // namespace
