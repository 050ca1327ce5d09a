// Models that arrive block by block, from a server that the test plays.
#include "scene/stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/error.h"
#include "fetch/request_queue.h"
#include "scene/plan.h"
#include "scene/reference.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

// What is there of a file, byte by byte.
class Shelf : public splat::BlockSource {
  public:
    Shelf(const Bytes& file, const std::vector<bool>& is_there) : file_(file), is_there_(is_there) {}
    std::string name() const override { return "shelf"; }
    uint64_t file_bytes() const override { return file_.size(); }
    const std::byte* data() const override { return file_.data(); }
    bool has(uint64_t offset, uint64_t size) const override {
        const auto begin = is_there_.begin() + ptrdiff_t(offset);
        return std::all_of(begin, begin + ptrdiff_t(size), [](bool is_there) { return is_there; });
    }

  private:
    const Bytes& file_;
    const std::vector<bool>& is_there_;
};

void mark(std::vector<bool>& is_there, const splat::CodedPlace& place) {
    std::fill_n(is_there.begin() + ptrdiff_t(place.offset), place.size, true);
}

// Brings the first `most` of what it is asked for, at once.
class Bringer : public scene::BlockFetcher {
  public:
    Bringer(const splat::Model& model, std::vector<bool>& is_there, size_t most)
        : model_(model), is_there_(is_there), most_(most) {}
    void ask(std::span<const scene::BlockRequest> requests) override {
        asked_.assign(requests.begin(), requests.end());
    }
    bool wait(double) override {
        std::vector<splat::CodedPlace> places;
        for (size_t i = 0; i < std::min(most_, asked_.size()); ++i) {
            places.push_back(model_.next_bytes(asked_[i].block).place);
            EXPECT_FALSE(is_there_[places.back().offset]) << "asked for what is there";
        }
        asked_.clear();
        for (const splat::CodedPlace& place : places) {
            bytes_ += is_there_[place.offset] ? 0 : place.size;  // many blocks may want one page
            mark(is_there_, place);
        }
        return !places.empty();
    }
    bool has_ended() const override { return false; }
    uint64_t most_bytes(const scene::BlockRequest& request) const override {
        const splat::FoundPlace next = model_.next_bytes(request.block);
        return next.place.size + (next.is_block ? 0 : splat::kMostPageBytes + splat::kMinBlockSize);
    }
    Counters counters() override { return {bytes_, 0, round_trip_s, bytes_per_s, window_bytes}; }
    uint64_t bytes() const { return bytes_; }
    // Of the last time, in order.
    std::vector<uint64_t> asked_blocks() const {
        std::vector<uint64_t> blocks;
        for (const scene::BlockRequest& r : asked_) blocks.push_back(r.block);
        return blocks;
    }

    // Of the last time, those that somebody waits for.
    std::vector<uint64_t> urgent_blocks() const {
        std::vector<uint64_t> blocks;
        for (const scene::BlockRequest& r : asked_)
            if (r.priority >= fetch::kIdlePriority) blocks.push_back(r.block);
        return blocks;
    }

    double round_trip_s = 0, bytes_per_s = 0;
    uint64_t window_bytes = 0;

  private:
    const splat::Model& model_;
    std::vector<bool>& is_there_;
    size_t most_;
    uint64_t bytes_ = 0;
    std::vector<scene::BlockRequest> asked_;
};

// A model of which the first block is there.
struct Arriving {
    explicit Arriving(const Bytes& bytes, size_t most = 7)
        : file(bytes),
          is_there(with_header(bytes)),
          model(std::make_unique<Shelf>(file, is_there)),
          bringer(model, is_there, most) {
        bring(0);
    }
    static std::vector<bool> with_header(const Bytes& bytes) {
        std::vector<bool> is_there(bytes.size(), false);
        mark(is_there, {0, splat::header_extent(bytes)});
        return is_there;
    }
    void bring(uint64_t block) {
        for (bool is_whole = false; !is_whole;) {
            const splat::FoundPlace next = model.next_bytes(block);
            mark(is_there, next.place);
            is_whole = next.is_block;
        }
        model.take_stock();
    }
    bool is_whole() const {
        model.take_stock();
        for (uint64_t b = 0; b < model.blocks_present(); ++b)
            if (!model.is_there(b)) return false;
        return true;
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

// Of several pages of the index, most of them not there at first; and what was decoded stays when its bytes
// go.
TEST(Stream, CompressedModelsSettleToTheSamePicture) {
    const Bytes plain = build_bytes(bumpy_torus(200, 400)), coded = compressed(plain);
    const splat::Model whole = open_model(plain);
    ASSERT_GT(whole.blocks_present(), splat::kPageEntries);
    const geom::View view = fitted_view(whole);
    const Drawn expected = draw({{&whole}}, view);
    for (const scene::Order order : {scene::Order::gain, scene::Order::y}) {
        Arriving arriving(coded);
        EXPECT_FALSE(arriving.model.next_bytes(splat::kPageEntries).is_block);
        scene::StreamOptions options;
        options.order.order = order;
        options.prefetches = false;
        scene::ModelPainter painter(arriving.model);
        scene::Stream stream({{&arriving.model}}, arriving.bringer, options);
        stream.show({view}, {});
        stream.settle(painter);
        EXPECT_EQ(draw({{&arriving.model}}, view).frame.rgb, expected.frame.rgb) << int(order);
        EXPECT_LT(arriving.bringer.bytes(), coded.size());
        std::fill(arriving.is_there.begin(), arriving.is_there.end(), false);
        arriving.model.take_stock();
        EXPECT_EQ(draw({{&arriving.model}}, view).frame.rgb, expected.frame.rgb) << "after eviction";
    }
}

// Of a page, of a coded block, and of the file's size.
TEST(Stream, DamageOfACompressedModelIsToldWhenItIsMet) {
    const Bytes coded = compressed(build_bytes(bumpy_torus(60, 160)));
    const splat::Model whole = open_model(coded);
    const auto fault_of = [&](const Bytes& bytes) -> std::string {
        try {
            Arriving arriving(bytes);
            for (uint64_t b = 0; b < arriving.model.blocks_present(); ++b) {
                arriving.bring(b);
                arriving.model.any_block(b);
            }
            return "";
        } catch (const core::Error& error) {
            return error.what();
        }
    };
    EXPECT_EQ(fault_of(coded), "");
    Bytes page = coded, block = coded, cut = coded;
    page[splat::header_extent(coded) + 9] ^= std::byte{1};
    EXPECT_NE(fault_of(page).find("index page 0 of level 0"), std::string::npos) << fault_of(page);
    block[whole.prefix_bytes(3) + 30] ^= std::byte{1};
    EXPECT_NE(fault_of(block).find("block 4 at byte"), std::string::npos) << fault_of(block);
    cut.resize(cut.size() - 1);
    EXPECT_NE(fault_of(cut).find("is cut off at byte"), std::string::npos) << fault_of(cut);
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
        for (uint64_t b = 1; b < arriving.model.blocks_present(); ++b)
            if (random.unit() < share) arriving.bring(b);
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
    for (uint64_t b = 1; b < 5; ++b) arriving.bring(b);
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
    const Bytes plain = build_bytes(bumpy_torus(100, 260)), coded = compressed(plain);
    for (const uint64_t budget : {uint64_t{0}, uint64_t{1000}, uint64_t{20'000}, uint64_t{50'000}})
        for (const Bytes& bytes : {plain, coded}) {
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

// While a camera goes on as it went, what it will see a round trip, a frame and 0.2 s later.
TEST(Stream, AsksForWhatASteadyCameraWillSee) {
    const mesh::Mesh mesh = bumpy_torus(100, 260);
    const Bytes bytes = build_bytes(mesh);
    Arriving arriving(bytes, 0);  // what is there stays as it is
    arriving.bringer.round_trip_s = 0.3;
    for (uint64_t b = 1; b < 20; ++b) arriving.bring(b);
    scene::ModelPainter painter(arriving.model);
    scene::Stream stream({{&arriving.model}}, arriving.bringer, {});
    scene::LackFinder finder({{&arriving.model}});
    const geom::View start = fitted_view(open_model(bytes));
    const glm::dvec3 step = 0.02 * glm::length(start.eye) * start.right;
    const auto look = [&](double steps, double time_s) {
        geom::View view = start;
        view.eye += steps * step;
        stream.show({view}, {}, time_s);
        Drawn drawn;
        drawn.report = painter.draw(view, {}, drawn.frame);
        stream.look(painter, drawn.report);
        return arriving.bringer.asked_blocks();
    };
    const auto needed = [&](double steps) {
        geom::View view = start;
        view.eye += steps * step;
        std::vector<uint64_t> blocks;
        for (const auto& r :
             scene::requests_for(finder.find(view, {}, std::nullopt), {}, view.picture_height()))
            blocks.push_back(r.block);
        return blocks;
    };
    constexpr double kFrame = 0.1;
    EXPECT_EQ(look(0, 0), needed(0));
    EXPECT_EQ(look(1, kFrame), needed(1)) << "two views are no steady motion yet";
    EXPECT_EQ(look(2, 2 * kFrame), needed(2 + (0.3 + kFrame + 0.2) / kFrame));
    EXPECT_NE(needed(2), needed(8)) << "or nothing is shown by this";
    EXPECT_EQ(look(1, 3 * kFrame), needed(1)) << "it turned back";
    EXPECT_EQ(look(0, 4 * kFrame), needed(0 - 6));
}

// The daemon sends for what is not seen only as far as it fills the link.
TEST(Stream, NobodyWaitsForWhatFillsTheLinkOrIdleTime) {
    const Bytes bytes = build_bytes(bumpy_torus(100, 260));
    const geom::View view = fitted_view(open_model(bytes));
    Arriving arriving(bytes, 1000);
    arriving.bringer.window_bytes = 10 * open_model(bytes).header().block_size;
    scene::DrawOptions coarse;
    coarse.cut.threshold_px = 8;
    scene::Stream stream({{&arriving.model}}, arriving.bringer, {});
    stream.show({view}, coarse);
    scene::LackFinder finder({{&arriving.model}});
    bool has_filled = false, has_idled = false;
    for (int i = 0; i < 40 && !arriving.is_whole(); ++i) {
        stream.ask_ahead();
        const auto seen =
            scene::requests_for(finder.find(view, coarse, std::nullopt), {}, view.picture_height());
        EXPECT_EQ(arriving.bringer.urgent_blocks().size(), seen.size());
        const bool has_more = arriving.bringer.asked_blocks().size() > seen.size();
        has_filled = has_filled || (has_more && !seen.empty());
        has_idled = has_idled || (has_more && seen.empty());
        arriving.bringer.wait(0);
    }
    EXPECT_TRUE(has_filled);
    EXPECT_TRUE(has_idled);
    EXPECT_TRUE(arriving.is_whole());
}

TEST(Stream, FetchesTheRestInIdleTimeUnlessItIsNotTo) {
    const Bytes bytes = build_bytes(bumpy_torus(100, 260));
    const geom::View view = fitted_view(open_model(bytes));
    for (const bool prefetches : {true, false}) {
        Arriving arriving(bytes, 1000);
        scene::StreamOptions options;
        options.prefetches = prefetches;
        scene::ModelPainter painter(arriving.model);
        scene::Stream stream({{&arriving.model}}, arriving.bringer, options);
        stream.wait_until(stream.elapsed_s() + 0.001);  // before there is a view
        EXPECT_TRUE(arriving.bringer.asked_blocks().empty());
        scene::DrawOptions coarse;
        coarse.cut.threshold_px = 8;
        stream.show({view}, coarse);
        stream.settle(painter);
        const uint64_t shown = arriving.bringer.bytes();
        for (int i = 0; i < 20; ++i) stream.wait_until(stream.elapsed_s() + 0.01);
        EXPECT_EQ(arriving.is_whole(), prefetches);
        EXPECT_EQ(arriving.bringer.bytes() > shown, prefetches);
    }
}

TEST(Stream, FillsALongLinkFromTheBeginningOfTheFileUnlessAllIsWaitedFor) {
    const Bytes bytes = build_bytes(bumpy_torus(100, 260));
    const geom::View view = fitted_view(open_model(bytes));
    const auto asked = [&](uint64_t window, bool prefetches, bool settles) {
        Arriving arriving(bytes, settles ? 1000 : 0);
        arriving.bringer.window_bytes = window;
        arriving.bringer.round_trip_s = 0.5, arriving.bringer.bytes_per_s = double(window) / 0.5;
        scene::StreamOptions options;
        options.prefetches = prefetches;
        scene::ModelPainter painter(arriving.model);
        scene::Stream stream({{&arriving.model}}, arriving.bringer, options);
        stream.show({view}, {});
        if (settles)
            stream.settle(painter);
        else
            stream.ask_ahead();
        std::vector<uint64_t> blocks = arriving.bringer.asked_blocks();
        blocks.push_back(arriving.bringer.bytes());
        return blocks;
    };
    const uint64_t block = open_model(bytes).header().block_size;
    const std::vector<uint64_t> lacking = asked(0, true, false);
    ASSERT_LT(lacking.size(), 20u);
    // What is lacking comes first; then all there is from the first block that is not there, in order: two
    // windows of both.
    const std::vector<uint64_t> filled = asked(10 * block, true, false);
    ASSERT_EQ(filled.size(), 21u);
    EXPECT_TRUE(std::equal(lacking.begin(), lacking.end() - 1, filled.begin()));
    EXPECT_TRUE(std::is_sorted(filled.begin() + ptrdiff_t(lacking.size()) - 1, filled.end() - 1));
    std::vector<uint64_t> sorted(filled.begin(), filled.end() - 1);
    std::sort(sorted.begin(), sorted.end());
    for (size_t i = 0; i < sorted.size(); ++i) EXPECT_EQ(sorted[i], i + 1);

    EXPECT_EQ(asked(10 * block, false, false), lacking);
    const uint64_t no_wider_gaps = 2 * block;  // than without
    EXPECT_EQ(asked(no_wider_gaps, true, true), asked(0, true, true));
}

TEST(Plan, IsWithinASeventhOfWhatIsFetched) {
    const mesh::Mesh mesh = bumpy_torus(200, 600);
    const Bytes bytes = build_bytes(mesh);
    const splat::Model whole = open_model(bytes);
    std::vector<geom::View> views = random_views(whole, mesh, 3);
    views.push_back(fitted_view(whole));
    for (const geom::View& view : views)
        for (const double threshold_px : {0.5, 4.0}) {
            Arriving arriving(bytes, 64);
            scene::DrawOptions draw;
            draw.cut.threshold_px = threshold_px;
            scene::ModelPainter painter(arriving.model);
            const auto settle = [&](std::optional<uint64_t> budget) {
                scene::StreamOptions options;
                options.prefetches = false;
                options.byte_budget = budget;
                scene::Stream stream({{&arriving.model}}, arriving.bringer, options);
                stream.show({view}, draw);
                stream.settle(painter);
            };
            settle(scene::kPlanBytes);
            Drawn drawn;
            drawn.report = painter.draw(view, draw, drawn.frame);
            const std::vector<scene::PlacedModel> placed{{&arriving.model}};
            const scene::Plan plan =
                scene::plan_of(placed, scene::LackFinder(placed).find(view, draw, std::nullopt), draw.cut);
            settle({});
            const auto needed = double(painter.draw(view, draw, drawn.frame).bytes_touched);
            EXPECT_NEAR(double(plan.present_bytes + plan.missing_bytes), needed, needed / 7)
                << threshold_px << " px of " << plan.file_bytes;
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
