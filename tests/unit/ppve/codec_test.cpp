#include "ppve/codec.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/error.h"
#include "core/parallel.h"
#include "ppve/lzw.h"
#include "ppve/sample/raster_sampler.h"
#include "scenes.h"

namespace {

using ppve::Codec;

// Surfaces, noise and gaps: `density` of the pixels stay.
ppve::DepthImage image_of(int width, int height, double density, bool normals, uint64_t seed) {
    std::mt19937_64 random(seed);
    ppve::DepthImage image;
    image.frustum = ppve_test::looking_from({0, 0, 3}, {0, 0, 0}, width, height);
    image.clear(normals);
    for (size_t p = 0; p < image.pixels(); ++p) {
        if (ppve_test::uniform(random, 0, 1) >= density) continue;
        const size_t i = p % size_t(width), j = p / size_t(width);
        image.depth[p] =
            random() % 50 == 0 ? uint32_t(random() | 1) : uint32_t(100000 + 7 * i + 13 * j + random() % 4);
        image.colour[p] = uint32_t(random() % 20 == 0 ? random() : (i * 3 + j) * 0x010101) & 0xffffff;
        if (normals) image.normal[p] = uint16_t(random());
    }
    return image;
}

void expect_lossless(const ppve::DepthImage& image, Codec codec) {
    const auto bytes = ppve::encode(image, codec);
    ppve::DepthImage back;
    back.frustum = image.frustum;
    ppve::decode(bytes, codec, !image.normal.empty(), back);
    EXPECT_EQ(back.depth, image.depth);
    EXPECT_EQ(back.colour, image.colour);
    EXPECT_EQ(back.normal, image.normal);
}

TEST(Codec, IsLosslessForAnySizeAndDensity) {
    uint64_t seed = 1;
    for (const Codec codec : {Codec::planes, Codec::lzw})
        for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(1, 200), glm::ivec2(200, 1),
                                      glm::ivec2(63, 65), glm::ivec2(64, 64), glm::ivec2(301, 130)})
            for (const double density : {0.0, 0.03, 0.5, 1.0})
                for (const bool normals : {false, true})
                    expect_lossless(image_of(size.x, size.y, density, normals, ++seed), codec);
}

TEST(Codec, TheSameBytesForAnyNumberOfThreads) {
    const ppve::DepthImage image = image_of(300, 300, 0.7, true, 3);
    core::set_thread_count(1);
    const auto one = ppve::encode(image, Codec::planes);
    core::set_thread_count(7);
    const auto many = ppve::encode(image, Codec::planes);
    core::set_thread_count(0);
    EXPECT_EQ(one, many);
}

// The paper's way against ours on what it is for; the figures of real scans are measured by scripts/bench.
TEST(Codec, PlanesTakeLessThanHalfOfLzw) {
    const mesh::Mesh ball = ppve_test::ball(300, 1);
    ppve::RasterSampler sampler{ppve::Clusters(ball)};
    ppve::DepthImage image, exact;
    image.frustum = exact.frustum = ppve_test::looking_from({0, 0, 3}, {0, 0, 0}, 400, 300);
    ppve::prepare(sampler, 0.01, image), ppve::prepare(sampler, 0, exact);
    sampler.sample(image, false), sampler.sample(exact, false);
    const auto lzw = ppve::encode(exact, Codec::lzw).size();
    EXPECT_LT(double(ppve::encode(image, Codec::planes).size()), 0.42 * double(lzw));
    EXPECT_LT(double(ppve::encode(exact, Codec::planes).size()), 0.55 * double(lzw));
}

TEST(Codec, WhatIsCutOffOrTooLongIsRefused) {
    const ppve::DepthImage image = image_of(150, 140, 0.5, true, 4);
    for (const Codec codec : {Codec::planes, Codec::lzw}) {
        auto bytes = ppve::encode(image, codec);
        ppve::DepthImage back;
        back.frustum = image.frustum;
        for (size_t size = 0; size < bytes.size(); size += bytes.size() / 97 + 1)
            EXPECT_THROW(ppve::decode(std::span(bytes).first(size), codec, true, back), core::Error) << size;
        bytes.push_back(std::byte{0});
        EXPECT_THROW(ppve::decode(bytes, codec, true, back), core::Error);
        EXPECT_THROW(ppve::decode(std::span(bytes).first(bytes.size() - 1), codec, false, back), core::Error);
    }
}

TEST(Lzw, IsLosslessBeyondSeveralDictionaries) {
    std::mt19937_64 random(5);
    for (const int alphabet : {1, 2, 200}) {
        std::vector<std::byte> bytes(400'000);
        for (auto& b : bytes) b = std::byte(random() % uint64_t(alphabet));
        std::vector<std::byte> back(bytes.size());
        ppve::lzw_decode(ppve::lzw_encode(bytes), back);
        EXPECT_EQ(back, bytes) << alphabet;
    }
    EXPECT_TRUE(ppve::lzw_encode({}).empty());
}

}  // namespace
