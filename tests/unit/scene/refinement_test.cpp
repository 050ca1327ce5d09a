// Refinement: which thresholds follow each other, and that they end.
#include "scene/refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scene/draw.h"
#include "test_meshes.h"
#include "views.h"

using namespace splat_test;
using namespace scene_test;

namespace {

std::vector<double> thresholds(double first_px, double last_px) {
    splat::CutCounts more_to_come;
    more_to_come.closed = 1;
    std::vector<double> all;
    for (std::optional<double> next = first_px; next;
         next = scene::refined_threshold(*next, last_px, more_to_come))
        all.push_back(*next);
    return all;
}

}  // namespace

TEST(Refinement, FallsByOneFactorToTheLastThreshold) {
    const std::vector<double> all = thresholds(32, 1);
    ASSERT_EQ(all.size(), 11u);
    for (size_t i = 0; i + 1 < all.size(); ++i) EXPECT_NEAR(all[i], 32 * std::pow(2.0, -double(i) / 2), 1e-9);
    EXPECT_EQ(all.back(), 1);
}

TEST(Refinement, NeverDrawsNearlyTheSameTwice) {
    for (double last_px = 0.03; last_px < 30; last_px *= 1.013) {
        const std::vector<double> all = thresholds(32, last_px);
        for (size_t i = 1; i < all.size(); ++i) EXPECT_LT(all[i], 0.95 * all[i - 1]) << last_px;
        EXPECT_EQ(all.back(), last_px);
    }
}

TEST(Refinement, EndsForAnyLastThreshold) {
    for (const double last_px : {0.0, 1e-300, 1e-6}) {
        EXPECT_LE(thresholds(32, last_px).size(), 24u);
        EXPECT_EQ(thresholds(32, last_px).back(), last_px);
    }
    EXPECT_EQ(thresholds(32, 32), std::vector<double>{32});
    EXPECT_EQ(thresholds(32, 1e6), std::vector<double>{32});
}

TEST(Refinement, EndsWhereTheModelHasNothingFiner) {
    const splat::Model model = build_model(bumpy_torus(60, 160));
    const geom::View view = fitted_view(model);
    scene::ModelPainter painter(model);
    render::Frame frame;
    scene::DrawOptions options;
    size_t drawn = 0;
    scene::DrawReport report;
    for (std::optional<double> next = scene::kFirstRefinementPx; next; ++drawn) {
        options.cut.threshold_px = *next;
        report = painter.draw(view, options, frame);
        next = scene::refined_threshold(*next, 0, report.counts);
    }
    EXPECT_GT(drawn, 3u);
    EXPECT_GT(options.cut.threshold_px, 0);
    render::Frame all_detail;
    options.cut.threshold_px = 0;
    EXPECT_EQ(painter.draw(view, options, all_detail).counts.splats, report.counts.splats);
    EXPECT_EQ(frame.rgb, all_detail.rgb);
}
