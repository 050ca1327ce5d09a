#include "ppve/octree.h"

#include <gtest/gtest.h>

#include <random>

#include "ball_scene.h"
#include "core/error.h"
#include "core/parallel.h"
#include "ppve/elimination.h"

namespace {

using namespace ppve;

TreeShape small_leaves() {
    TreeShape shape = shape_around(test::scene_bounds());
    shape.levels = 6;
    shape.leaf_points = 200;
    return shape;
}

Change adding(uint64_t update, const DepthImage& image) {
    Change change;
    change.update = update;
    change.added = &image;
    return change;
}

std::vector<ClusterId> ids_of(const Octree& tree) {
    std::vector<ClusterId> ids;
    tree.for_each([&](const Cluster& cluster) { ids.push_back(cluster.id); });
    return ids;
}

// What the other side is, as bytes that would be compared: every point of every patch.
void expect_equal(const Octree& a, const Octree& b) {
    ASSERT_EQ(ids_of(a), ids_of(b));
    a.for_each([&](const Cluster& cluster) {
        const Cluster* other = b.find(cluster.id);
        ASSERT_EQ(cluster.patches.size(), other->patches.size());
        for (size_t k = 0; k < cluster.patches.size(); ++k) {
            const Patch &p = *cluster.patches[k], &q = *other->patches[k];
            ASSERT_EQ(p.anchor(), q.anchor());
            ASSERT_EQ(p.points().x, q.points().x);
            ASSERT_EQ(p.points().y, q.points().y);
            ASSERT_EQ(p.points().z, q.points().z);
            ASSERT_EQ(p.points().colour, q.points().colour);
            ASSERT_EQ(p.points().normal, q.points().normal);
        }
    });
    EXPECT_EQ(a.checksum(), b.checksum());
}

TEST(Octree, HoldsEverySampleAtItsPlace) {
    const DepthImage image = test::sample(test::frustum_at({0, 1, 4}, {0, 0, 0}, 160, 100));
    Octree tree(small_leaves());
    tree.apply(adding(1, image));
    EXPECT_EQ(tree.points(), image.samples());
    double worst = 0;
    tree.for_each([&](const Cluster& cluster) {
        for (const auto& patch : cluster.patches)
            for (size_t i = 0; i < patch->size(); ++i) {
                const PatchPoints& p = patch->points();
                const glm::dvec3 world =
                    patch->anchor() + tree.shape().unit() * glm::dvec3(p.x[i], p.y[i], p.z[i]);
                const Projected at = project(image.frustum, world);
                const int x = int(std::floor(at.x)), y = int(std::floor(at.y));
                const uint32_t code = image.depth[size_t(y * 160 + x)];
                ASSERT_NE(code, 0u);
                const glm::dvec3 exact = position_of(image.frustum, image.coding, x, y, code);
                worst =
                    std::max(worst, glm::length(world - exact) / glm::length(exact - image.frustum.view.eye));
            }
    });
    EXPECT_LT(worst, 0x1p-22);
}

TEST(Octree, LeavesAreLimitedInPointsAndLevels) {
    Octree tree(small_leaves());
    const DepthImage image = test::sample(test::frustum_at({0, 1, 4}, {0, 0, 0}, 160, 100));
    for (uint64_t k = 1; k <= 3; ++k) tree.apply(adding(k, image));
    size_t largest = 0;
    tree.for_each([&](const Cluster& cluster) {
        const int level = (int(std::bit_width(cluster.id)) - 1) / 3;
        EXPECT_LE(level, tree.shape().levels);
        if (level < tree.shape().levels) largest = std::max(largest, cluster.points());
    });
    EXPECT_GT(largest, 0u);
    EXPECT_LE(largest, tree.shape().leaf_points);
}

TEST(Octree, SplittingTwiceIsTheSameAsSplittingAtOnce) {
    // Points that are split on arrival and those split later lie in the same leaves, but for the rounding of
    // those that lie on a border; here none does.
    const DepthImage image = test::sample(test::frustum_at({0.013, 1.07, 4}, {0, 0, 0}, 160, 100));
    TreeShape coarse = small_leaves();
    coarse.leaf_points = 5000;
    Octree at_once(small_leaves()), later(coarse);
    at_once.apply(adding(1, image));
    later.apply(adding(1, image));
    EXPECT_LT(later.clusters(), at_once.clusters());
    EXPECT_EQ(later.points(), at_once.points());
}

TEST(Octree, IsTheSameForAnyNumberOfThreads) {
    const DepthImage image = test::sample(test::frustum_at({0, 1, 4}, {0, 0, 0}, 160, 100), true);
    Octree one(small_leaves()), many(small_leaves());
    core::set_thread_count(1);
    one.apply(adding(1, image));
    core::set_thread_count(5);
    many.apply(adding(1, image));
    core::set_thread_count(0);
    expect_equal(one, many);
}

TEST(Octree, ForgetsWhatIsObsoleteAndPassesOverWhatIsUnknown) {
    Octree tree(small_leaves());
    const DepthImage image = test::sample(test::frustum_at({0, 1, 4}, {0, 0, 0}, 160, 100));
    tree.apply(adding(1, image));
    const uint64_t full_bytes = tree.bytes();
    Change change;
    change.obsolete = ids_of(tree);
    for (const ClusterId odd : {ClusterId(0), ClusterId(2), ClusterId(6), ClusterId(1), ~ClusterId(0)})
        change.obsolete.push_back(odd);
    tree.apply(change);
    EXPECT_EQ(tree.points(), 0u);
    EXPECT_EQ(tree.clusters(), 0u);
    EXPECT_EQ(tree.checksum(), 0u);
    tree.apply(adding(2, image));
    EXPECT_LE(tree.bytes(), full_bytes);  // the tree's nodes are used again
}

TEST(Octree, RefusesRemovalsThatDoNotFit) {
    Octree tree(small_leaves());
    tree.apply(adding(1, test::sample(test::frustum_at({0, 1, 4}, {0, 0, 0}, 160, 100))));
    const ClusterId id = ids_of(tree).front();
    const size_t points = tree.find(id)->patches[0]->size();
    Change change;
    const auto refuses = [&](const Removal& removal) {
        change.removed = {removal};
        const uint64_t before = tree.checksum();
        EXPECT_THROW(tree.apply(change), core::Error);
        EXPECT_EQ(tree.checksum(), before);
    };
    refuses({id, 1, std::vector<uint8_t>(points)});
    refuses({id, 0, std::vector<uint8_t>(points + 1)});
    refuses({id << 3, 0, std::vector<uint8_t>(points)});
    refuses({0, 0, {}});
}

// Any surface, seen from anywhere, by two trees that see the same changes, of which one gets the removals by
// way of bytes; and a third that misses one.
TEST(Octree, BothSidesAreEqualAfterEveryMessageOfRandomSessions) {
    for (const unsigned seed : {1u, 2u, 3u}) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> number(-1, 1);
        Octree server(small_leaves()), client(small_leaves());
        for (uint64_t update = 1; update <= 40; ++update) {
            const glm::dvec3 eye{4 * number(random), 2.2 + number(random), 4 * number(random)};
            DepthImage image =
                test::sample(test::frustum_at(eye, {number(random), 0, number(random)}, 80, 60), false,
                             update % 5 == 0 ? 0.5 : 1);
            const Elimination kind = update % 7 == 0 ? Elimination::paper : Elimination::filtered;
            Change change;
            if (update == 25) change.starts_anew = true;
            if (update % 3 == 0)
                for (const ClusterId id : ids_of(server))
                    if (random() % 10 == 0) change.obsolete.push_back(id);
            // As a server does it: first what goes, then elimination against what is left.
            Change first = change;
            server.apply(first);
            const Eliminated eliminated = eliminate(server, {kind, 0.01, 1.4}, image);
            change.removed = eliminated.removed;
            change.update = update;
            change.added = &image;
            server.apply({false, {}, change.removed, update, &image});

            change.removed = read_removals(write_removals(change.removed), client.points());
            client.apply(change);
            expect_equal(server, client);
            if (HasFatalFailure()) return;
        }
        EXPECT_GT(server.points(), 1000u);
        Octree behind = client;
        DepthImage image = test::sample(test::frustum_at({0, 3, 0.1}, {0, 0, 0}, 80, 60));
        client.apply(adding(41, image));
        EXPECT_NE(behind.checksum(), client.checksum());
        image.colour[image.pixels() / 2] ^= 1;
        behind.apply(adding(41, image));
        EXPECT_NE(behind.checksum(), client.checksum());
    }
}

TEST(Octree, ShapesThatCannotBeAreRefused) {
    TreeShape shape;
    for (const double side : {0.0, -1.0, std::nan(""), double(INFINITY)}) {
        shape.side = side;
        EXPECT_THROW(Octree{shape}, core::Error) << side;
    }
    shape = {};
    shape.levels = 21;
    EXPECT_THROW(Octree{shape}, core::Error);
    shape = {};
    shape.corner.y = std::nan("");
    EXPECT_THROW(Octree{shape}, core::Error);
}

TEST(Octree, HoldsScenesOfAnySize) {
    for (const double size : {1e-30, 1.0, 1e30}) {
        Box box;
        box.add({-size, -size, 5 * size});
        box.add({size, size, 6 * size});
        const TreeShape shape = shape_around(box);
        DepthImage image;
        image.frustum = test::frustum_at({0, 0, 0}, {0, 0, size}, 40, 30);
        image.coding = choose_coding(image.frustum, 0.01, size, 10 * size);
        image.clear(false);
        for (auto& depth : image.depth) depth = image.coding.code(5.5 * size);
        Octree tree(shape);
        tree.apply(adding(1, image));
        EXPECT_EQ(tree.points(), image.pixels()) << size;
    }
}

}  // namespace
