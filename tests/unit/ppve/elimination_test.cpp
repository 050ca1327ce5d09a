#include "ppve/elimination.h"

#include <gtest/gtest.h>

#include <random>

#include "ball_scene.h"
#include "core/error.h"
#include "core/parallel.h"

namespace {

using namespace ppve;

struct Session {
    Octree tree{shape_around(test::scene_bounds())};
    EliminationRule rule;
    uint64_t update = 0;
    EliminationCounts last;

    void look(const Frustum& frustum, double footprint_px = 1) {
        DepthImage image = test::sample(frustum, false, footprint_px);
        const Eliminated eliminated = eliminate(tree, rule, image);
        last = eliminated.counts;
        tree.apply({false, {}, eliminated.removed, ++update, &image});
    }
};

Frustum from(double angle, double distance, int width = 200, int height = 150) {
    return test::frustum_at({distance * std::sin(angle), 0.6, distance * std::cos(angle)}, {0, 0, 0}, width,
                            height);
}

TEST(Elimination, TheSameViewAgainBringsNothing) {
    Session session;
    session.look(from(0, 4));
    EXPECT_EQ(session.last.kept, session.last.samples);
    session.look(from(0, 4));
    // A point whose pixel is at the border of rounding may fall beside it.
    EXPECT_LT(double(session.last.kept), 0.002 * double(session.last.samples));
    EXPECT_EQ(session.last.removed, 0u);
}

TEST(Elimination, NoneKeepsAll) {
    Session session;
    session.rule.kind = Elimination::none;
    session.look(from(0, 4));
    session.look(from(0, 4));
    EXPECT_EQ(session.last.kept, session.last.samples);
}

TEST(Elimination, AnOrbitSendsLittleTwice) {
    Session session;
    uint64_t samples = 0, kept = 0;
    for (int k = 0; k < 20; ++k) {
        session.look(from(0.05 * k, 4));
        if (k > 0) samples += session.last.samples, kept += session.last.kept;
    }
    EXPECT_LT(double(kept), 0.25 * double(samples));
}

TEST(Elimination, ComingNearerLosesDetailByThePapersRuleAndNoneByOurs) {
    for (const Elimination kind : {Elimination::paper, Elimination::filtered}) {
        Session session;
        session.rule = {kind, 0.02, 1.4};
        uint64_t samples = 0, lost = 0;
        for (double distance = 6; distance > 1.6; distance *= 0.8) {
            session.look(from(0.1, distance));
            samples += session.last.samples, lost += session.last.lost;
        }
        if (kind == Elimination::paper)
            EXPECT_GT(double(lost), 0.1 * double(samples));
        else
            EXPECT_EQ(lost, 0u);
    }
}

TEST(Elimination, CoarsePointsGiveWayToFineOnes) {
    Session session;
    session.look(from(0, 6, 200, 150));
    const uint64_t coarse = session.tree.points();
    session.look(from(0, 6, 800, 600));
    // All of them but those at the outlines, where a footprint is not held wholly.
    EXPECT_GT(double(session.last.removed), 0.85 * double(coarse));
    EXPECT_EQ(session.last.kept, session.last.samples);
}

TEST(Elimination, ARefinementOfHalfAPixelIsKept) {
    Session session;
    session.look(from(0, 4));
    Frustum shifted = from(0, 4);
    shifted.view.shift_px = {0.5, 0.5};
    session.look(shifted, 0.5);
    EXPECT_GT(double(session.last.kept), 0.98 * double(session.last.samples));
}

TEST(Elimination, WhatLiesInFrontIsKept) {
    // The ball hides a part of the plane that was seen before from above.
    Session session;
    session.look(test::frustum_at({0, 8, 2.5}, {0, -1, 2.5}, 300, 300));
    session.look(from(0, 4));
    EXPECT_GT(session.last.kept, session.last.samples / 4);
}

TEST(Elimination, IsTheSameForAnyNumberOfThreads) {
    Session session;
    for (int k = 0; k < 4; ++k) session.look(from(0.3 * k, 5));
    std::vector<uint32_t> kept[2];
    std::vector<std::byte> removed[2];
    for (const int threads : {1, 5}) {
        core::set_thread_count(threads);
        DepthImage image = test::sample(from(0.2, 3));
        const Eliminated eliminated = eliminate(session.tree, {}, image);
        kept[threads > 1] = image.depth;
        removed[threads > 1] = write_removals(eliminated.removed);
    }
    core::set_thread_count(0);
    EXPECT_EQ(kept[0], kept[1]);
    EXPECT_EQ(removed[0], removed[1]);
}

TEST(Elimination, WorksForParallelRays) {
    Session session;
    Frustum frustum = from(0, 4);
    frustum.projection = Projection::orthographic;
    frustum.view.focal_px = 60;
    frustum.view.near = 0.5, frustum.view.far = 9;
    DepthImage image;
    image.frustum = frustum;
    image.coding = choose_coding(frustum, 0.01, 0.5, 9);
    image.clear(false);
    for (auto& depth : image.depth) depth = image.coding.code(4);
    DepthImage again = image;
    session.tree.apply({false, {}, {}, 1, &image});
    const Eliminated eliminated = eliminate(session.tree, {}, again);
    EXPECT_LT(eliminated.counts.kept, image.pixels() / 100);
    // Nearer by a footprint and a half: another surface.
    for (auto& depth : again.depth) depth = again.coding.code(4 - 1.5 / 60);
    EXPECT_EQ(eliminate(session.tree, {}, again).counts.kept, image.pixels());
}

TEST(Removals, ComeBackAsTheyWere) {
    std::mt19937 random(7);
    std::vector<Removal> removals(20);
    uint64_t points = 0;
    for (Removal& removal : removals) {
        removal = {random(), static_cast<uint32_t>(random() % 9), std::vector<uint8_t>(1 + random() % 300)};
        for (auto& bit : removal.is_removed) bit = random() & 1;
        points += removal.is_removed.size();
    }
    const std::vector<std::byte> bytes = write_removals(removals);
    const std::vector<Removal> back = read_removals(bytes, points);
    ASSERT_EQ(back.size(), removals.size());
    for (size_t k = 0; k < back.size(); ++k) {
        EXPECT_EQ(back[k].cluster, removals[k].cluster);
        EXPECT_EQ(back[k].patch, removals[k].patch);
        EXPECT_EQ(back[k].is_removed, removals[k].is_removed);
    }
    EXPECT_THROW(read_removals(bytes, points - 1), core::Error);
    EXPECT_TRUE(read_removals({}, 0).empty());
}

TEST(Removals, CutOffOrDamagedBytesAreRefused) {
    const std::vector<Removal> removals{{9, 0, {1, 0, 1, 1, 0, 0, 0, 1, 1}}, {10, 2, {1}}};
    std::vector<std::byte> bytes = write_removals(removals);
    for (size_t size = 1; size < bytes.size(); ++size)
        EXPECT_THROW(read_removals(std::span(bytes).first(size), 1000), core::Error) << size;
    std::mt19937 random(3);
    for (int k = 0; k < 2000; ++k) {
        std::vector<std::byte> damaged = bytes;
        damaged[random() % damaged.size()] ^= std::byte(1 << random() % 8);
        try {
            uint64_t points = 0;
            for (const Removal& removal : read_removals(damaged, 1000)) points += removal.is_removed.size();
            EXPECT_LE(points, 1000u);
        } catch (const core::Error&) {
        }
    }
}

}  // namespace
