// Thresholds and budgets beyond what anybody asks for.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "scene/budget_painter.h"
#include "subject.h"
#include "table.h"

namespace stability {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const Subject& unit_model() {
    static const Subject subject = build(bumpy_sphere(), Precision::single);
    return subject;
}

struct Value {
    const char* name;
    double value;
    bool is_all_detail;  // as a threshold
};

std::ostream& operator<<(std::ostream& out, const Value& value) {
    return out << value.name;
}

const Value kThresholds[] = {
    {"0", 0, true},        {"1e_300", 1e-300, true},        {"1e_30", 1e-30, true},    {"1e6", 1e6, false},
    {"1e38", 1e38, false}, {"1e300", 1e300, false},         {"inf", kInfinity, false}, {"nan", kNaN, true},
    {"minus_1", -1, true}, {"minus_inf", -kInfinity, true},
};

class Thresholds : public testing::TestWithParam<Value> {};

// All detail, or the coarsest there is; complete in any case.
TEST_P(Thresholds, DrawCompletePictures) {
    const Value& threshold = GetParam();
    const Subject& subject = unit_model();
    for (const splat::CutBy by : {splat::CutBy::error, splat::CutBy::diameter}) {
        const std::string row =
            "threshold " + std::string(threshold.name) + (by == splat::CutBy::error ? "" : " of diameter");
        scene::DrawOptions options = all_detail();
        const Picture finest = draw(subject, fitted_camera(subject), options);
        options.cut.by = by;
        options.cut.threshold_px = threshold.value;
        const Picture picture = draw(subject, fitted_camera(subject), options);
        expect_at_most(row, "bad pixels", double(bad_pixels(picture.frame)), 0);
        expect_at_most(row, "holes", double(difference_from_mesh(subject, picture).holes), 0);
        expect_at_most(row, "splats", double(picture.report.counts.splats),
                       threshold.is_all_detail ? double(finest.report.counts.splats) : 7);
        if (threshold.is_all_detail) {
            EXPECT_EQ(picture.frame.rgb, finest.frame.rgb);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Table, Thresholds, testing::ValuesIn(kThresholds),
                         testing::PrintToStringParamName());

class Budgets : public testing::TestWithParam<Value> {};

// A budget that cannot be kept draws something complete in about the least time; one that is never spent
// draws all that the threshold allows.
TEST_P(Budgets, DrawCompletePictures) {
    const Value& budget = GetParam();
    const Subject& subject = unit_model();
    const std::string row = "budget " + std::string(budget.name) + " ms";
    scene::ModelPainter painter(*subject.model);
    scene::BudgetPainter budget_painter(painter, budget.value);
    scene::DrawOptions options = all_detail();
    const Picture finest = draw(subject, fitted_camera(subject), options);
    Picture picture = finest;
    for (int i = 0; i < 20; ++i) {
        options = all_detail();
        picture.report = budget_painter.draw(picture.view, options, picture.frame);
        expect_at_most(row, "bad pixels", double(bad_pixels(picture.frame)), 0);
        expect_at_most(row, "holes", double(difference_from_mesh(subject, picture).holes), 0);
        expect_at_least(row, "threshold px", options.cut.threshold_px, 0);
        EXPECT_TRUE(std::isfinite(budget_painter.report().predicted_ms));
        if (budget.is_all_detail) {
            EXPECT_EQ(picture.frame.rgb, finest.frame.rgb);
        }
    }
}

const Value kBudgets[] = {
    {"1e_300", 1e-300, false}, {"1e_3", 1e-3, false},  {"1", 1, false},
    {"1e9", 1e9, true},        {"1e300", 1e300, true}, {"inf", kInfinity, true},
};

INSTANTIATE_TEST_SUITE_P(Table, Budgets, testing::ValuesIn(kBudgets), testing::PrintToStringParamName());

class NoBudgets : public testing::TestWithParam<Value> {};

TEST_P(NoBudgets, AreRefused) {
    EXPECT_THROW(scene::FrameBudget(GetParam().value), core::Error);
}

const Value kNoBudgets[] = {{"0", 0, false}, {"minus_1", -1, false}, {"nan", kNaN, false}};

INSTANTIATE_TEST_SUITE_P(Table, NoBudgets, testing::ValuesIn(kNoBudgets), testing::PrintToStringParamName());

// Thresholds may be anything a cut takes; the profile still grows from step to step.
TEST(Profiles, HoldForAnyFinestThreshold) {
    const Subject& subject = unit_model();
    const geom::View view = geom::make_view(fitted_camera(subject), 200, 150);
    for (const Value& threshold : kThresholds) {
        const splat::CutProfile profile =
            splat::Cut(*subject.model).profile(view, {}, {threshold.value, 1e18, 64});
        for (int step = 0; step < splat::CutProfile::kSteps; ++step) {
            EXPECT_FALSE(std::isnan(profile.threshold_px(step))) << threshold.name;
            EXPECT_TRUE(std::isfinite(profile.at(step).splats + profile.at(step).pixels)) << threshold.name;
            EXPECT_GE(profile.at(step).splats, -1e-6) << threshold.name;
        }
    }
}

}  // namespace
}  // namespace stability
