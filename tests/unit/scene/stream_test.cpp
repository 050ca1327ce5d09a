// Models that arrive block by block, from a server that the test plays.
#include "scene/stream.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "scene/reference.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

// What is there of a file.
class Shelf : public splat::BlockSource {
  public:
    Shelf(const Bytes& file, const std::vector<bool>& is_there) : file_(file), is_there_(is_there) {}
    std::string name() const override { return "shelf"; }
    uint64_t file_bytes() const override { return file_.size(); }
    const std::byte* data() const override { return file_.data(); }
    bool has(uint64_t offset, uint64_t size) const override {
        if (offset + size <= splat::kBlocksAt) return true;
        return is_there_[(offset - splat::kBlocksAt) / splat::kMinBlockSize];
    }

  private:
    const Bytes& file_;
    const std::vector<bool>& is_there_;
};

// Brings the first `most` of what it is asked for, at once.
class Bringer : public scene::BlockFetcher {
  public:
    Bringer(std::vector<bool>& is_there, size_t most) : is_there_(is_there), most_(most) {}
    void ask(std::span<const scene::BlockRequest> requests) override {
        asked_.assign(requests.begin(), requests.end());
    }
    bool wait(double) override {
        const size_t count = std::min(most_, asked_.size());
        for (size_t i = 0; i < count; ++i) {
            EXPECT_FALSE(is_there_[asked_[i].block]) << "asked for what is there";
            is_there_[asked_[i].block] = true;
            bytes_ += splat::kMinBlockSize;
        }
        asked_.clear();
        return count > 0;
    }
    bool has_ended() const override { return false; }
    Counters counters() override { return {bytes_, 0, 0}; }
    uint64_t bytes() const { return bytes_; }

  private:
    std::vector<bool>& is_there_;
    size_t most_;
    uint64_t bytes_ = 0;
    std::vector<scene::BlockRequest> asked_;
};

// A model of which the first block is there.
struct Arriving {
    explicit Arriving(const Bytes& bytes, size_t most = 7)
        : file(bytes),
          is_there((bytes.size() - splat::kBlocksAt) / splat::kMinBlockSize, false),
          model(std::make_unique<Shelf>(file, is_there)),
          bringer(is_there, most) {
        is_there[0] = true;
    }
    const Bytes& file;
    std::vector<bool> is_there;
    splat::Model model;
    Bringer bringer;
};

constexpr scene::Order kOrders[] = {scene::Order::gain,   scene::Order::level, scene::Order::radius,
                                    scene::Order::screen, scene::Order::y,     scene::Order::sweep};

}  // namespace

TEST(Stream, SettlesToThePictureOfTheWholeInAnyOrder) {
    const mesh::Mesh mesh = bumpy_torus(100, 260);
    const Bytes bytes = build_bytes(mesh);
    const splat::Model whole = open_model(bytes);
    for (const geom::View& view : random_views(whole, mesh, 3)) {
        const Drawn expected = draw({{&whole}}, view);
        for (const scene::Order order : kOrders) {
            Arriving arriving(bytes);
            scene::StreamOptions options;
            options.order.order = order;
            scene::ModelPainter painter(arriving.model);
            scene::Stream stream({{&arriving.model}}, arriving.bringer, options);
            stream.show({view}, {});
            stream.settle(painter);
            Drawn drawn;
            drawn.report = painter.draw(view, {}, drawn.frame);
            EXPECT_EQ(drawn.frame.rgb, expected.frame.rgb) << int(order);
            EXPECT_EQ(drawn.frame.depth, expected.frame.depth) << int(order);
            const scene::StreamReport report = stream.look(painter, drawn.report);
            EXPECT_EQ(report.visible_blocks_missing, 0u);
            EXPECT_TRUE(report.full_coverage_s);
            // Settled once, it is settled.
            const uint64_t fetched = arriving.bringer.bytes();
            stream.show({view}, {});
            stream.settle(painter);
            EXPECT_EQ(arriving.bringer.bytes(), fetched);
        }
    }
}

TEST(Stream, WhateverHasArrivedHasNoHolesThatTheWholeHasNot) {
    const mesh::Mesh mesh = bumpy_torus(100, 260);
    const Bytes bytes = build_bytes(mesh);
    const splat::Model whole = open_model(bytes);
    const geom::View view = fitted_view(whole);
    // Splats reach beyond the surface by different amounts; holes are where the surface is and no splat.
    scene::Reference reference(mesh, "torus", false);
    const auto holes_of = [&](const Drawn& drawn) {
        return reference.measure(view, {}, drawn.frame).difference.holes;
    };
    const auto full_holes = holes_of(draw({{&whole}}, view));
    Random random(5);
    for (int i = 0; i < 20; ++i) {
        Arriving arriving(bytes);
        const double share = random.unit();
        for (size_t b = 1; b < arriving.is_there.size(); ++b) arriving.is_there[b] = random.unit() < share;
        EXPECT_LE(holes_of(draw({{&arriving.model}}, view)), full_holes) << share;
    }
}

TEST(Stream, WhatIsHiddenOrFineEnoughAsksForNothing) {
    // A ball within a ball: the inner one owns no pixel.
    const Bytes outer_bytes = build_bytes(icosphere(6)), inner_bytes = build_bytes(scaled(icosphere(6), 0.5));
    Arriving outer(outer_bytes), inner(inner_bytes);
    scene::LackFinder finder({{&outer.model}, {&inner.model}});
    const geom::View view = fitted_view(open_model(outer_bytes));
    size_t waiting_inside = 0;
    for (const scene::Lack& lack : finder.find(view, {}, std::nullopt)) {
        if (lack.model == 0) continue;
        ++waiting_inside;
        EXPECT_EQ(lack.pixels, 0);
    }
    EXPECT_GT(waiting_inside, 0u);
    for (const scene::BlockRequest& r :
         scene::requests_for(finder.find(view, {}, std::nullopt), {}, view.picture_height()))
        EXPECT_EQ(r.model, 0u);
    scene::DrawOptions coarse;
    coarse.cut.threshold_px = 1e6;
    EXPECT_TRUE(finder.find(view, coarse, std::nullopt).empty());
}

TEST(Stream, FirstBringsWhatTheMagnifierHolds) {
    const mesh::Mesh mesh = bumpy_torus(100, 260);
    const Bytes bytes = build_bytes(mesh);
    Arriving arriving(bytes);
    const geom::View view = fitted_view(open_model(bytes));
    scene::LackFinder finder({{&arriving.model}});
    for (size_t b = 1; b < 5; ++b) arriving.is_there[b] = true;
    scene::Magnifier magnifier;
    magnifier.at = view.principal() + glm::dvec2(0.3 * view.height, 0),
    magnifier.radius_px = view.height / 8.0;
    double inside = 0, plain = 0;
    for (const scene::Lack& lack : finder.find(view, {}, magnifier)) inside += lack.pixels;
    for (const scene::Lack& lack : finder.find(view, {}, std::nullopt)) plain += lack.pixels;
    EXPECT_GT(inside, plain);
    EXPECT_LE(plain, double(view.width) * view.height);
}

TEST(Stream, KeepsToItsBudget) {
    const Bytes bytes = build_bytes(bumpy_torus(100, 260));
    for (const uint64_t budget : {uint64_t{0}, uint64_t{1000}, uint64_t{20'000}, uint64_t{50'000}}) {
        Arriving arriving(bytes, 3);
        scene::StreamOptions options;
        options.byte_budget = budget;
        scene::ModelPainter painter(arriving.model);
        scene::Stream stream({{&arriving.model}}, arriving.bringer, options);
        stream.show({fitted_view(open_model(bytes))}, {});
        stream.settle(painter);
        EXPECT_LE(arriving.bringer.bytes(), budget);
        EXPECT_GT(arriving.bringer.bytes() + splat::kMinBlockSize, budget);
    }
}

TEST(RequestOrder, BringsWhatOwnsMorePixelsTimesErrorFirstAndSumsOverABlock) {
    scene::Lack a{0, {}, {}, 10}, b{0, {}, {}, 4}, hidden{0, {}, {}, 0};
    a.node.block = 3, a.node.error_px = 1;
    b.node.block = 7, b.node.error_px = 2;
    hidden.node.block = 9, hidden.node.error_px = INFINITY, hidden.node.diameter_px = 1;
    const auto requests = scene::requests_for(std::vector{a, b, b, hidden}, {}, 100);
    ASSERT_EQ(requests.size(), 2u);
    EXPECT_EQ(requests[0].block, 7u);
    EXPECT_FLOAT_EQ(requests[0].priority, 16);
    EXPECT_EQ(requests[1].block, 3u);
    const auto of_hidden = scene::requests_for_hidden(std::vector{a, b, hidden});
    ASSERT_EQ(of_hidden.size(), 1u);
    EXPECT_TRUE(std::isfinite(of_hidden[0].priority));
}

TEST(RequestOrder, SweepsGoFromTheTopDownAndFromLargeToSmall) {
    std::vector<scene::Lack> lacks;
    for (const float diameter : {30.0f, 17.0f, 1e-20f, INFINITY})
        for (const float y : {90.0f, 10.0f, NAN}) {
            scene::Lack lack{0, {}, {0, y}, 1};
            lack.node.block = lacks.size();
            lack.node.diameter_px = diameter;
            lacks.push_back(lack);
        }
    scene::OrderOptions options;
    options.order = scene::Order::sweep;
    const auto requests = scene::requests_for(lacks, options, 100);
    ASSERT_EQ(requests.size(), 12u);
    EXPECT_EQ(requests[0].block, 11u) << "the widest, and without a place";
    for (size_t i = 0; i < requests.size(); ++i) {
        EXPECT_TRUE(std::isfinite(requests[i].priority) && requests[i].priority > 0);
        EXPECT_EQ(requests[i].block / 3, (i < 3 ? 3 : i / 3 - 1)) << i;
    }
}
