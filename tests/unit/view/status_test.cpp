#include "view/status.h"

#include <gtest/gtest.h>

#include <limits>

#include "view/feedback.h"
#include "view/meter.h"
#include "view/refinement_share.h"

namespace {

TEST(Status, SaysWhatThereIsAndNothingElse) {
    view::PictureReport report;
    report.splats = 412'345, report.threshold_px = 2.828, report.error_bound_px = 1.91;
    EXPECT_EQ(view::status_line(report, {31.2, 0}),
              "31 frames/s   412 k splats   threshold 2.83 px   error below 1.91 px");
    report.error_bound_px = std::numeric_limits<double>::infinity();
    report.arrival = {3'100'000, 12, 0.5};
    EXPECT_EQ(view::status_line(report, {0, 1'234'000}),
              "412 k splats   threshold 2.83 px   12 blocks missing   3.10 MB fetched   1.23 MB/s");
}

TEST(Legend, NamesTheColourOfEachSize) {
    const std::vector<view::LegendEntry> entries = view::legend({});
    ASSERT_EQ(entries.size(), 9u);
    for (size_t i = 1; i < entries.size(); ++i) EXPECT_NE(entries[i].colour, entries[i - 1].colour);
    EXPECT_EQ(entries[0].text, "below 1 px");
    EXPECT_EQ(entries[2].text, "2 to 4 px");
    view::PictureReport report;
    report.has_leaf_triangles = true;
    EXPECT_EQ(view::legend(report)[0].text, "below 1 px, or the mesh itself");
}

TEST(Meter, TellsTheRateOfTheLastWhile) {
    view::Meter meter(1);
    for (int i = 0; i <= 30; ++i) meter.note(i, i / 30.0);
    EXPECT_NEAR(meter.rate(1), 30, 1e-9);
    EXPECT_EQ(meter.rate(5), 0);
    meter.note(0, 6);
    EXPECT_EQ(meter.rate(6), 0);
}

// Frames that take 1000 ms / threshold^2: 30 ms is 5.8 px.
TEST(Feedback, FindsTheThresholdThatKeepsTheTime) {
    view::Feedback feedback;
    for (int i = 0; i < 20; ++i) {
        const double px = feedback.threshold_px(1);
        feedback.learn(px, 1000 / (px * px), 30);
    }
    EXPECT_NEAR(feedback.threshold_px(1), std::sqrt(1000.0 / 30), 0.01);
    EXPECT_EQ(feedback.threshold_px(9), 9);
}

TEST(RefinementShare, GrowsFromNothingToAll) {
    EXPECT_EQ(view::refinement_share(32, 1), 0);
    EXPECT_NEAR(view::refinement_share(std::sqrt(32.0), 1), 0.5, 1e-12);
    EXPECT_EQ(view::refinement_share(1, 1), 1);
    EXPECT_EQ(view::refinement_share(0, 0), 1);
    EXPECT_EQ(view::refinement_share(100, 64), 0);
}

}  // namespace
