#include "ppve/client/reconstruction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ball_scene.h"
#include "core/error.h"
#include "core/parallel.h"
#include "ppve/octree.h"

namespace {

using namespace ppve;

Octree tree_of(std::initializer_list<DepthImage> images) {
    TreeShape shape = shape_around(test::scene_bounds());
    shape.leaf_points = 2000;
    Octree tree(shape);
    uint64_t update = 0;
    for (const DepthImage& image : images) tree.apply({false, {}, {}, ++update, &image});
    return tree;
}

PointModel model_of(const Octree& tree) {
    PointModel model;
    model.unit = tree.shape().unit();
    tree.for_each([&](const Cluster& cluster) {
        auto drawn = std::make_shared<DrawnCluster>();
        drawn->id = cluster.id;
        for (const auto& patch : cluster.patches) drawn->patches.push_back(decimate(patch, model.unit));
        model.clusters.push_back(drawn);
    });
    return model;
}

ReconstructionOptions plain() {
    ReconstructionOptions options;
    options.look.shade = render::Shade::flat;
    return options;
}

render::Frame drawn(const PointModel& model, const geom::View& view, const ReconstructionOptions& options,
                    ReconstructionCounts* counts = nullptr) {
    Reconstruction reconstruction;
    render::Frame frame;
    const auto all = reconstruction.draw(model, {&view, 1}, options, {&frame, 1});
    if (counts) *counts = all[0];
    return frame;
}

// Of pixels where the exact picture shows a surface: how many of the frame's are empty, and the error of the
// others.
struct Difference {
    double empty = 0, psnr_db = 0;
};
Difference difference(const render::Frame& frame, const DepthImage& exact) {
    double square = 0, covered = 0, empty = 0;
    for (size_t i = 0; i < exact.pixels(); ++i) {
        if (exact.depth[i] == 0) continue;
        ++covered;
        if (!std::isfinite(frame.depth[i])) {
            ++empty;
            continue;
        }
        for (size_t c = 0; c < 3; ++c) {
            const double d = double(frame.rgb[3 * i + c]) - double(exact.colour[i] >> 8 * c & 0xff);
            square += d * d;
        }
    }
    return {empty / covered, 10 * std::log10(255 * 255 * 3 * (covered - empty) / square)};
}

TEST(PatchLevels, HaveTheMeanColourAndTheLeastDepthOfEachSquare) {
    DepthImage image;
    image.frustum = test::frustum_at({0, 0.5, 3}, {0, 0, 0}, 8, 8);
    image.coding = choose_coding(image.frustum, 1e-4, 1, 10);
    image.clear(false);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
            image.depth[size_t(8 * y + x)] = image.coding.code(2 + 0.1 * x + 0.3 * y);
            image.colour[size_t(8 * y + x)] = uint32_t(10 * x) | uint32_t(20 * y) << 8 | 7 << 16;
        }
    const Octree tree = tree_of({image});
    ASSERT_EQ(tree.clusters(), 1u);
    std::shared_ptr<const PatchLevels> levels;
    tree.for_each([&](const Cluster& c) { levels = decimate(c.patches[0], tree.shape().unit()); });
    ASSERT_EQ(levels->levels(), 4u);  // 8, 4, 2, 1 a side
    const PatchPoints& half = levels->points(1);
    ASSERT_EQ(half.size(), 16u);
    for (int i = 0; i < 16; ++i) {
        const int x = i % 4, y = i / 4;
        EXPECT_EQ(half.colour[size_t(i)], uint32_t(20 * x + 5) | uint32_t(40 * y + 10) << 8 | 7 << 16);
        const glm::dvec3 offset(half.x[size_t(i)], half.y[size_t(i)], half.z[size_t(i)]);
        const Projected at = project(image.frustum, levels->patch->anchor() + offset * tree.shape().unit());
        EXPECT_NEAR(at.x, 2 * x + 1, 1e-4);
        EXPECT_NEAR(at.y, 2 * y + 1, 1e-4);
        EXPECT_NEAR(at.depth, 2 + 0.2 * x + 0.6 * y, 1e-3);
    }
}

TEST(PatchLevels, ConesHoldAllNormalsAndCullOnlyWhatIsSeenFromBehind) {
    const DepthImage image = test::sample(test::frustum_at({0, 0.5, 4}, {0, 0, 0}, 160, 120), true);
    TreeShape shape = shape_around(test::scene_bounds());
    shape.leaf_points = 100;
    Octree tree(shape);
    tree.apply({false, {}, {}, 1, &image});
    size_t cones = 0, away = 0;
    const glm::dvec3 behind{0, 0.5, -4};
    tree.for_each([&](const Cluster& cluster) {
        const auto levels = decimate(cluster.patches[0], shape.unit());
        const PatchPoints& p = levels->patch->points();
        cones += levels->cone.cos_half_angle > 0;
        EXPECT_FALSE(faces_away(*levels, image.frustum.view.eye, shape.unit()));
        if (!faces_away(*levels, behind, shape.unit())) return;
        ++away;
        for (size_t i = 0; i < p.size(); ++i) {
            const glm::dvec3 world =
                levels->patch->anchor() + glm::dvec3(p.x[i], p.y[i], p.z[i]) * shape.unit();
            EXPECT_LT(glm::dot(glm::dvec3(octahedral_normal(p.normal[i])), behind - world), 0.1);
        }
    });
    EXPECT_GT(cones, 10u);
    EXPECT_GT(away, 3u);
}

TEST(Reconstruction, OfItsOwnViewIsTheSamplesThemselves) {
    const Frustum frustum = test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 201, 151);
    const DepthImage image = test::sample(frustum);
    const Difference d = difference(drawn(model_of(tree_of({image})), frustum.view, plain()), image);
    EXPECT_EQ(d.empty, 0);
    EXPECT_GT(d.psnr_db, 60);
}

TEST(Reconstruction, AtTwiceTheResolutionHasHardlyAHole) {
    const DepthImage image = test::sample(test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 160, 120));
    const Frustum fine = test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 320, 240);
    const DepthImage exact = test::sample(fine);
    const PointModel model = model_of(tree_of({image}));
    ReconstructionOptions options = plain();
    const Difference at_1 = difference(drawn(model, fine.view, options), exact);
    options.scale = 1.25;
    const Difference at_more = difference(drawn(model, fine.view, options), exact);
    EXPECT_LT(at_1.empty, 0.004);
    EXPECT_LE(at_more.empty, at_1.empty);
    EXPECT_GT(at_1.psnr_db, 28);
}

TEST(Reconstruction, FromAfarTakesDecimatedPatches) {
    const DepthImage image = test::sample(test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 640, 480));
    const Frustum far = test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 80, 60);
    const PointModel model = model_of(tree_of({image}));
    ReconstructionCounts counts;
    const Difference d = difference(drawn(model, far.view, plain(), &counts), test::sample(far));
    EXPECT_LT(counts.points_chosen, image.samples() / 30);
    EXPECT_LT(d.empty, 0.01);
    EXPECT_GT(d.psnr_db, 24);
}

TEST(Reconstruction, AMovingEyeAsksForLess) {
    const Frustum frustum = test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 320, 240);
    const PointModel model = model_of(tree_of({test::sample(frustum)}));
    ReconstructionOptions options = plain();
    ReconstructionCounts at_rest, moving;
    drawn(model, frustum.view, options, &at_rest);
    options.velocity = 2;
    const Difference d = difference(drawn(model, frustum.view, options, &moving), test::sample(frustum));
    EXPECT_LT(moving.points_chosen, at_rest.points_chosen / 3);
    EXPECT_LT(d.empty, 0.005);
}

TEST(Reconstruction, KeepsItsBudgetOfPoints) {
    const Frustum frustum = test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 320, 240);
    const PointModel model = model_of(tree_of({test::sample(frustum)}));
    ReconstructionOptions options = plain();
    options.most_points = 20000;
    ReconstructionCounts counts;
    const render::Frame frame = drawn(model, frustum.view, options, &counts);
    EXPECT_LE(counts.points_chosen, options.most_points);
    EXPECT_GT(counts.points_chosen, options.most_points / 2);
    EXPECT_GT(counts.coarser_for_budget, 0u);
    EXPECT_LT(difference(frame, test::sample(frustum)).empty, 0.01);
}

// A coarse patch in front of a fine one, by the depth of its own error.
TEST(Reconstruction, TheRuleKeepsCoarsePatchesFromHidingFineOnes) {
    DepthImage coarse, fine;
    fine.frustum = test::frustum_at({0, 0, 3}, {0, 0, 0}, 200, 200);
    coarse.frustum = test::frustum_at({0, 0, 3}, {0, 0, 0}, 25, 25);
    for (DepthImage* image : {&coarse, &fine}) {
        image->coding = choose_coding(image->frustum, 1e-4, 1, 10);
        image->clear(false);
        for (size_t i = 0; i < image->pixels(); ++i) {
            image->depth[i] = image->coding.code(image == &coarse ? 2.999 : 3);
            image->colour[i] = image == &coarse ? 0xff : 0xff00;
        }
    }
    Octree tree(shape_around(test::scene_bounds()));
    tree.apply({false, {}, {}, 1, &coarse});
    tree.apply({false, {}, {}, 2, &fine});
    // Only where both are in one cluster there is a rule.
    const PointModel model = model_of(tree);
    const auto green = [&](double ratio) {
        ReconstructionOptions options = plain();
        options.ratio = ratio;
        const render::Frame frame = drawn(model, fine.frustum.view, options);
        size_t count = 0;
        for (size_t i = 0; i < fine.pixels(); ++i) count += frame.rgb[3 * i + 1] == 0xff;
        return double(count) / double(fine.pixels());
    };
    EXPECT_LT(green(0), 0.1);
    EXPECT_GT(green(1.5), 0.7);
}

TEST(Reconstruction, TwoEyesAreAsEachForItselfAndForAnyNumberOfThreads) {
    const Frustum frustum = test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 200, 150);
    const PointModel model = model_of(tree_of({test::sample(frustum, true)}));
    const geom::View views[2] = {geom::moved_aside(frustum.view, -0.05, 4),
                                 geom::moved_aside(frustum.view, 0.05, 4)};
    ReconstructionOptions options;
    options.scale = 1.25;
    for (const int threads : {1, 2, 5}) {
        core::set_thread_count(threads);
        Reconstruction reconstruction;
        render::Frame both[2];
        reconstruction.draw(model, views, options, both);
        for (int k = 0; k < 2; ++k) {
            const render::Frame alone = drawn(model, views[k], options);
            EXPECT_EQ(both[k].rgb, alone.rgb) << threads;
            EXPECT_EQ(both[k].depth, alone.depth) << threads;
        }
    }
    core::set_thread_count(0);
}

TEST(Reconstruction, DrawsNothingOfNothing) {
    const geom::View view = test::frustum_at({0.4, 0.8, 4}, {0, 0, 0}, 20, 15).view;
    ReconstructionOptions options = plain();
    options.look.background = {1, 2, 3};
    options.look.background_alpha = 0;
    const render::Frame frame = drawn({}, view, options);
    EXPECT_EQ(frame.rgb[0], 1);
    EXPECT_EQ(frame.rgb.back(), 3);
    EXPECT_EQ(frame.alpha.front(), 0);
    EXPECT_FALSE(std::isfinite(frame.depth[100]));
    options.look.samples_across = 2;
    EXPECT_THROW(drawn({}, view, options), core::UsageError);
}

TEST(Reconstruction, ClosesGapsWithoutFatterOutlines) {
    // Seen from aside and nearer, samples of one view leave gaps.
    const Octree tree = tree_of({test::sample(test::frustum_at({0, 0.5, 4}, {0, 0, 0}, 320, 240))});
    const PointModel model = model_of(tree);
    const Frustum aside = test::frustum_at({0.3, 0.6, 3.6}, {0, 0, 0}, 320, 240);
    const DepthImage exact = test::sample(aside);
    const auto beside = [&](const render::Frame& frame) {
        size_t count = 0;
        for (size_t i = 0; i < exact.pixels(); ++i)
            count += exact.depth[i] == 0 && std::isfinite(frame.depth[i]);
        return count;
    };
    ReconstructionOptions open = plain(), closed = plain(), larger = plain();
    closed.closes_gaps = true, larger.scale = 1.5;
    const render::Frame with_gaps = drawn(model, aside.view, open),
                        without = drawn(model, aside.view, closed), fat = drawn(model, aside.view, larger);
    EXPECT_LT(difference(without, exact).empty, 0.4 * difference(with_gaps, exact).empty);
    EXPECT_GT(difference(without, exact).psnr_db, difference(with_gaps, exact).psnr_db - 0.1);
    EXPECT_LT(10 * beside(without), 6 * beside(fat));
}

}  // namespace
