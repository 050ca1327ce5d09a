#include "ppve/client/point_raster.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "ball_scene.h"
#include "ppve/octree.h"

namespace {

using namespace ppve;

Octree tree_of(const DepthImage& image) {
    TreeShape shape = shape_around(test::scene_bounds());
    shape.leaf_points = 500;
    Octree tree(shape);
    Change change;
    change.update = 1;
    change.added = &image;
    tree.apply(change);
    return tree;
}

void draw_all(const Octree& tree, const PointView& view, const PatchStyle& style, PointRaster& raster,
              int first, int end) {
    tree.for_each([&](const Cluster& cluster) {
        for (const auto& patch : cluster.patches)
            if (view.may_see(*patch)) raster.draw(view, *patch, style, {}, first, end);
    });
}

PointRaster drawn(const Octree& tree, const Frustum& frustum, const PatchStyle& style = {}) {
    PointRaster raster;
    raster.resize(frustum.view.width, frustum.view.height);
    raster.clear(0, frustum.view.height);
    draw_all(tree, PointView(frustum, tree.shape().unit()), style, raster, 0, frustum.view.height);
    return raster;
}

uint32_t colour_of(uint64_t word) {
    return static_cast<uint32_t>(word);
}

TEST(PointRaster, DrawsTheSamplesOfItsOwnViewWhereTheyWere) {
    const Frustum frustum = test::frustum_at({0.3, 0.7, 4}, {0, 0, 0}, 203, 151);
    const DepthImage image = test::sample(frustum);
    const Octree tree = tree_of(image);
    const PointRaster raster = drawn(tree, frustum);
    const PointView view(frustum, tree.shape().unit());
    size_t differing = 0;
    for (int y = 0; y < 151; ++y)
        for (int x = 0; x < 203; ++x) {
            const uint64_t word = raster.row(y)[x];
            const size_t i = size_t(y * 203 + x);
            if ((word == PointRaster::kEmpty) != (image.depth[i] == 0) ||
                (image.depth[i] != 0 && colour_of(word) != image.colour[i])) {
                ++differing;
                continue;
            }
            if (image.depth[i] == 0) continue;
            EXPECT_NEAR(view.depth_of(word) / image.coding.depth(image.depth[i]), 1, 1e-6);
        }
    EXPECT_EQ(differing, 0u);
}

TEST(PointRaster, BandsMakeTheWhole) {
    const Octree tree = tree_of(test::sample(test::frustum_at({0.3, 0.7, 4}, {0, 0, 0}, 203, 151)));
    const Frustum frustum = test::frustum_at({1, 1, 2}, {0, 0, 0}, 320, 240);
    const PatchStyle style{1.25f};
    const PointRaster whole = drawn(tree, frustum, style);
    PointRaster bands;
    bands.resize(320, 240);
    bands.clear(0, 240);
    const PointView view(frustum, tree.shape().unit());
    for (const auto& [first, end] : {std::pair{100, 240}, std::pair{0, 37}, std::pair{37, 100}})
        tree.for_each([&, first = first, end = end](const Cluster& cluster) {
            for (const auto& patch : cluster.patches) {
                const PointView::Rows rows = view.rows_of(*patch);
                if (rows.first < end && rows.end > first) bands.draw(view, *patch, style, {}, first, end);
            }
        });
    for (int y = 0; y < 240; ++y)
        EXPECT_TRUE(std::equal(whole.row(y), whole.row(y) + 320, bands.row(y))) << "row " << y;
}

// Against a drawing of squares pixel by pixel.
TEST(PointRaster, SquaresCoverThePixelsWhoseCentresTheyHold) {
    const Octree tree = tree_of(test::sample(test::frustum_at({0.3, 0.7, 4}, {0, 0, 0}, 60, 40)));
    for (const int size : {60, 120, 900}) {
        const Frustum frustum = test::frustum_at({0.39, 0.75, 3.7}, {0, 0.02, 0}, size, size);
        const PointRaster raster = drawn(tree, frustum);
        if (size > 120) continue;  // drawn only: large splats write nothing outside of the raster
        std::vector<uint64_t> expected(size_t(size) * size_t(size), PointRaster::kEmpty);
        tree.for_each([&](const Cluster& cluster) {
            for (const auto& patch : cluster.patches)
                for (size_t i = 0; i < patch->size(); ++i) {
                    const PatchPoints& p = patch->points();
                    const glm::vec3 offset(p.x[i], p.y[i], p.z[i]);
                    const Projected at =
                        project(frustum, patch->anchor() + glm::dvec3(offset) * tree.shape().unit());
                    const double extent =
                        tree.shape().unit() *
                        double(patch->footprint_at_anchor() + glm::dot(patch->footprint_slope(), offset));
                    const double side = std::max(1.0, extent * frustum.view.focal_px / at.depth);
                    const auto depth = static_cast<float>(at.depth / tree.shape().unit());
                    for (int y = 0; y < size; ++y)
                        for (int x = 0; x < size; ++x)
                            if (std::fabs(x + 0.5 - at.x) <= side / 2 &&
                                std::fabs(y + 0.5 - at.y) <= side / 2) {
                                uint64_t& word = expected[size_t(y * size + x)];
                                word = std::min(word,
                                                uint64_t(std::bit_cast<uint32_t>(depth)) << 32 | p.colour[i]);
                            }
                }
        });
        size_t differing = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                differing += colour_of(raster.row(y)[x]) != colour_of(expected[size_t(y * size + x)]);
        EXPECT_LT(double(differing), 0.004 * size * size) << size;  // roundings at borders of pixels
    }
}

TEST(PointRaster, CoarsePointsCanBeLeftOut) {
    const Octree tree = tree_of(test::sample(test::frustum_at({0, 1, 4}, {0, 0, 0}, 100, 80)));
    PatchStyle style;
    style.most_px = 1.4f;
    const auto covered = [&](int width, int height) {
        const PointRaster raster = drawn(tree, test::frustum_at({0, 1, 4}, {0, 0, 0}, width, height), style);
        size_t count = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) count += raster.row(y)[x] != PointRaster::kEmpty;
        return count;
    };
    EXPECT_GT(covered(100, 80), 3000u);
    EXPECT_EQ(covered(150, 120), 0u);
}

TEST(PointRaster, ShadesByNormal) {
    const Frustum frustum = test::frustum_at({0, 1, 4}, {0, 0, 0}, 100, 80);
    const Octree tree = tree_of(test::sample(frustum, true));
    PointShading dark, red;
    dark.factor.assign(65536, 32768);
    red.colour.assign(65536, 0xff);
    PointRaster plain, halved, coloured;
    const PointView view(frustum, tree.shape().unit());
    for (auto& [raster, shading] : {std::pair{&plain, PointShading{}}, {&halved, dark}, {&coloured, red}}) {
        raster->resize(100, 80);
        raster->clear(0, 80);
        tree.for_each([&, &raster = raster, &shading = shading](const Cluster& cluster) {
            for (const auto& patch : cluster.patches) raster->draw(view, *patch, {}, shading, 0, 80);
        });
    }
    for (int x = 0; x < 100; ++x) {
        const uint64_t word = plain.row(60)[x];
        ASSERT_NE(word, PointRaster::kEmpty);
        EXPECT_EQ(colour_of(halved.row(60)[x]) & 0xff, ((colour_of(word) & 0xff) + 1) / 2);
        EXPECT_EQ(colour_of(coloured.row(60)[x]), 0xffu);
    }
}

TEST(PointRaster, SurvivesAnyView) {
    const Octree tree = tree_of(test::sample(test::frustum_at({0, 1, 4}, {0, 0, 0}, 100, 80)));
    std::mt19937 random(5);
    std::uniform_real_distribution<double> exponent(-12, 12), number(-1, 1);
    for (int k = 0; k < 200; ++k) {
        const double far_out = std::pow(10, exponent(random));
        const glm::dvec3 eye = far_out * glm::dvec3(number(random), number(random), number(random));
        const double fovy = k % 2 ? 1e-9 * std::pow(10, 0.9 * std::fabs(exponent(random))) : 175;
        const Frustum frustum =
            test::frustum_at(eye, {0, 0.001 * number(random), 0}, 33, 17, std::min(fovy, 170.0));
        const PointRaster raster = drawn(tree, frustum, {k % 3 ? 1.0f : 1e20f});
        for (int y = 0; y < 17; ++y)
            for (int x = 0; x < 33; ++x) EXPECT_LE(raster.row(y)[x], PointRaster::kEmpty);
    }
}

TEST(PointRaster, NothingIsCulledThatWouldBeSeen) {
    const Octree tree = tree_of(test::sample(test::frustum_at({0, 1, 4}, {0, 0, 0}, 100, 80)));
    std::mt19937 random(6);
    std::uniform_real_distribution<double> number(-1, 1);
    size_t culled = 0;
    for (int k = 0; k < 100; ++k) {
        const glm::dvec3 eye = 3.0 * glm::dvec3(number(random), number(random), number(random));
        const Frustum frustum = test::frustum_at(eye, {number(random), -1, number(random)}, 64, 48, 30);
        const PointView view(frustum, tree.shape().unit());
        PointRaster raster;
        raster.resize(64, 48);
        raster.clear(0, 48);
        tree.for_each([&](const Cluster& cluster) {
            for (const auto& patch : cluster.patches) {
                const PointView::Rows rows = view.rows_of(*patch);
                if (!view.may_see(*patch)) {
                    ++culled;
                    EXPECT_EQ(raster.draw(view, *patch, {}, {}, 0, 48), 0u);
                } else if (rows.first > 0) {
                    EXPECT_EQ(raster.draw(view, *patch, {}, {}, 0, rows.first), 0u);
                }
            }
        });
    }
    EXPECT_GT(culled, 10u);
}

}  // namespace
