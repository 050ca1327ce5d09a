#include "ppve/messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/error.h"
#include "scenes.h"

namespace {

using namespace ppve;

Request a_request() {
    Request r;
    r.id = 7, r.stamp = 123456789, r.footprint_px = 0.5, r.bound_px = 0.02;
    r.frustum = ppve_test::looking_from({1, 2, 3}, {0, 0, 0}, 320, 200);
    r.frustum.view.near = 1e-6, r.frustum.view.far = 1e9, r.frustum.view.shift_px = {3, -4};
    r.codec = Codec::lzw, r.elimination = Elimination::paper, r.epsilon = 1e-3, r.wants_normals = true;
    r.last_answer = 6, r.octree_checksum = ~uint64_t(0);
    r.deletions = {1, 9, 77};
    return r;
}

Answer an_answer() {
    Answer a;
    a.id = 7, a.stamp = 5, a.starts_anew = true, a.deleted = {3, 4},
    a.replaced = {std::byte(1), std::byte(2)};
    DepthImage image;
    image.frustum = ppve_test::looking_from({0, 0, 3}, {0, 0, 0}, 16, 9);
    image.coding = choose_coding(image.frustum, 0.01, 1, 10);
    image.clear(false);
    image.depth[20] = image.coding.code(2), image.colour[20] = 0x112233;
    a.frustum = image.frustum, a.coding = image.coding;
    a.image = encode(image, Codec::planes);
    a.octree_checksum = 99, a.samples = 4, a.samples_kept = 1, a.sample_ms = 2.5f;
    a.counts.bytes_touched = 1000;
    return a;
}

std::vector<Message> one_of_each() {
    Welcome w;
    w.bounds.add({-1, -2, -3}), w.bounds.add({4, 5, 6});
    w.most_pixels = 1000, w.most_points = 2000, w.scene = "crater.ply", w.sampler = "raster";
    return {w,
            a_request(),
            Deletions{{5, 6}},
            an_answer(),
            Refusal{3, "no"},
            StatusQuery{},
            Status{R"({"updates":1})"}};
}

TEST(Messages, ComeBackAsTheyWere) {
    for (const Message& m : one_of_each()) {
        const auto bytes = format(m);
        const Message back = parse(bytes, "here");
        EXPECT_EQ(back.index(), m.index());
        // All that a message holds is in its bytes.
        EXPECT_EQ(format(back), bytes);
    }
    const auto r = std::get<Request>(parse(format(a_request()), "here"));
    EXPECT_EQ(r.frustum.view.near, 1e-6);
    EXPECT_EQ(r.frustum.view.far, 1e9);
    EXPECT_EQ(r.deletions, (std::vector<uint64_t>{1, 9, 77}));
    const DepthImage image = image_of(std::get<Answer>(parse(format(an_answer()), "here")));
    EXPECT_EQ(image.samples(), 1u);
    EXPECT_EQ(image.colour[20], 0x112233u);
}

TEST(Messages, CutOffAnywhereOrTooLongAreRefused) {
    for (const Message& m : one_of_each()) {
        auto bytes = format(m);
        for (size_t size = 0; size < bytes.size(); ++size)
            EXPECT_THROW(parse(std::span(bytes).first(size), "here"), core::Error) << size;
        bytes.push_back(std::byte(0));
        EXPECT_THROW(parse(bytes, "here"), core::Error);
    }
}

TEST(Messages, AnyFlippedBitIsNoticed) {
    for (const Message& m : one_of_each()) {
        auto bytes = format(m);
        for (size_t bit = 0; bit < 8 * bytes.size(); bit += 3) {
            bytes[bit / 8] ^= std::byte(1 << bit % 8);
            EXPECT_THROW(parse(bytes, "here"), core::Error) << bit;
            bytes[bit / 8] ^= std::byte(1 << bit % 8);
        }
    }
}

// With the checksum right: what is out of range is refused for what it is.
TEST(Messages, NumbersOutOfRangeAreRefused) {
    const auto refused = [](const auto& spoil) {
        Request r = a_request();
        spoil(r);
        EXPECT_THROW(parse(format(r), "here"), core::Error);
    };
    refused([](Request& r) { r.footprint_px = NAN; });
    refused([](Request& r) { r.footprint_px = 0; });
    refused([](Request& r) { r.footprint_px = 1e9; });
    refused([](Request& r) { r.bound_px = -1; });
    refused([](Request& r) { r.bound_px = NAN; });
    refused([](Request& r) { r.epsilon = INFINITY; });
    refused([](Request& r) { r.frustum.view.eye.z = NAN; });
    refused([](Request& r) { r.frustum.view.width = 0; });
    refused([](Request& r) { r.frustum.view.width = kMostSide + 1; });
    refused([](Request& r) { r.frustum.view.forward *= 2; });
    refused([](Request& r) { r.frustum.projection = Projection(2); });
    refused([](Request& r) { r.codec = Codec(2); });
    refused([](Request& r) { r.elimination = Elimination(3); });
    refused([](Request& r) { r.deletions.resize(kMostDeletions + 1); });
    Answer a = an_answer();
    a.coding.bits = 53;
    EXPECT_THROW(parse(format(a), "here"), core::Error);
    a = an_answer(), a.coding.base = std::numeric_limits<int64_t>::max();
    EXPECT_THROW(parse(format(a), "here"), core::Error);
    Welcome w = std::get<Welcome>(one_of_each().front());
    w.bounds.high.x = INFINITY;
    EXPECT_THROW(parse(format(w), "here"), core::Error);
    w = std::get<Welcome>(one_of_each().front()), w.version = 2;
    EXPECT_THROW(parse(format(w), "here"), core::Error);
}

}  // namespace
