// Frame budgets, against simulated machines and models: no clock is read.
#include "scene/frame_budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace {

using scene::FrameBudget;
using splat::CutProfile;
using splat::CutSize;

// A model before a camera.
struct Scene {
    double splats_at_1px = 200e3;  // falling as threshold^-1.4
    double leaves = 4e6;           // none finer
    double overdraw_px = 1.5e6;
    double cold = 0;  // share of nodes that are used for the first time
};

CutSize size_of(const Scene& scene, double threshold_px) {
    const double splats = std::clamp(scene.splats_at_1px * std::pow(threshold_px, -1.4), 6.0, scene.leaves);
    return {1.4 * splats, scene.cold * 1.4 * splats, splats, scene.overdraw_px};
}

// Steps are told one after the other, from the coarsest cut on: what each finer one holds more.
CutProfile profile_of(const Scene& scene, const splat::ProfileOptions& options) {
    CutProfile profile(options, 921600);
    CutSize last;
    for (int step = CutProfile::kSteps - 1; step >= 0; --step) {
        const CutSize size = size_of(scene, profile.threshold_px(step));
        const double more = size.splats - last.splats;
        const double pixels = (size.pixels - last.pixels) / more;
        if (more > 0) profile.add_splat(0, step + 1, std::sqrt(std::max(pixels, 0.0) * 4 / M_PI), more);
        profile.add_nodes(step + 1, (size.nodes - last.nodes) * (1 - scene.cold), false);
        profile.add_nodes(step + 1, (size.nodes - last.nodes) * scene.cold, true);
        last = size;
    }
    const int waiting[] = {0};
    profile.limit(waiting, 0);
    profile.finish();
    return profile;
}

// How long frames take, which the budget does not know.
struct Machine {
    double frame_ms = 1.5, node_ns = 8, cold_ns = 20, splat_ns = 25, pixel_ns = 1;
    double slower = 1;   // than these
    double noise = 0;    // standard deviation, by time
    double hiccups = 0;  // share of the frames that take longer, by hiccup_ms
    double hiccup_ms = 6;
    std::mt19937 random{1};

    double draw_ms(const CutSize& size) {
        const double ms = slower * (frame_ms + 1e-6 * (node_ns * size.nodes + cold_ns * size.cold_nodes +
                                                       splat_ns * size.splats + pixel_ns * size.pixels));
        const double deviation = std::normal_distribution<double>(0, 1)(random);
        const bool stumbles = std::uniform_real_distribution<double>(0, 1)(random) < hiccups;
        return ms * std::exp(noise * deviation) + (stumbles ? hiccup_ms : 0);
    }
};

struct Frames {
    std::vector<double> ms, threshold_px, predicted_ms;

    double share_within(double limit_ms) const {
        return double(std::count_if(ms.begin(), ms.end(), [&](double m) { return m <= limit_ms; })) /
               double(ms.size());
    }
    double median_ms() const {
        std::vector<double> sorted = ms;
        std::nth_element(sorted.begin(), sorted.begin() + long(sorted.size() / 2), sorted.end());
        return sorted[sorted.size() / 2];
    }
};

// Draws frames, each of the scene and on the machine that `change` makes of it beforehand.
Frames draw(
    FrameBudget& budget, int count, Scene scene, Machine machine, double finest_px = 0.05,
    const std::function<void(int, Scene&, Machine&)>& change = [](int, Scene&, Machine&) {}) {
    Frames frames;
    for (int i = 0; i < count;) {
        change(i, scene, machine);
        const CutProfile profile = profile_of(scene, budget.profile_options(finest_px));
        const bool is_trial = budget.is_trial();
        const FrameBudget::Choice choice = budget.choose(profile, 0);
        const double ms = machine.draw_ms(size_of(scene, choice.threshold_px));
        budget.learn(choice, ms);
        if (is_trial) continue;
        frames.ms.push_back(ms);
        frames.threshold_px.push_back(choice.threshold_px);
        frames.predicted_ms.push_back(choice.predicted_ms);
        ++i;
    }
    return frames;
}

constexpr double kBudgetMs = 33, kTolerance = 1.2;

}  // namespace

TEST(FrameBudget, HoldsTheFirstFrameOnAMachineOfUnknownSpeed) {
    for (const double slower : {0.1, 0.3, 1.0, 3.0, 6.0}) {
        FrameBudget budget(kBudgetMs);
        Machine machine;
        machine.slower = slower;
        Scene scene;
        scene.leaves = 1e9;
        const Frames frames = draw(budget, 20, scene, machine);
        EXPECT_LE(frames.ms.front(), kTolerance * kBudgetMs) << slower;
        EXPECT_GE(frames.ms.front(), 0.5 * kBudgetMs) << slower;
        EXPECT_EQ(frames.share_within(kTolerance * kBudgetMs), 1) << slower;
        EXPECT_GE(frames.median_ms(), 0.85 * kBudgetMs) << slower;
    }
}
TEST(FrameBudget, TrialsTakeNoLongerThanFourFrames) {
    for (const double slower : {0.1, 1.0, 4.0}) {
        FrameBudget budget(kBudgetMs);
        Machine machine;
        machine.slower = slower;
        double sum_ms = 0;
        while (budget.is_trial()) {
            const CutProfile profile = profile_of({}, budget.profile_options(0.05));
            const FrameBudget::Choice choice = budget.choose(profile, 0);
            const double ms = machine.draw_ms(size_of({}, choice.threshold_px));
            budget.learn(choice, ms);
            sum_ms += ms;
        }
        EXPECT_LE(sum_ms, 4 * kBudgetMs) << slower;
    }
}

TEST(FrameBudget, IsNeverFinerThanTheFinestThreshold) {
    for (const double finest_px : {0.0, 1e-30, 0.5, 3.0, 1e6}) {
        FrameBudget budget(1e9);
        for (const double threshold_px : draw(budget, 5, {}, {}, finest_px).threshold_px)
            EXPECT_EQ(threshold_px, finest_px);
        FrameBudget tight(5);
        for (const double threshold_px : draw(tight, 30, {}, {}, finest_px).threshold_px)
            EXPECT_GE(threshold_px, finest_px);
    }
}

// Every other frame shows ten times as many splats at the same threshold, or a tenth.
TEST(FrameBudget, HoldsFramesThatTheCameraJumpsTo) {
    FrameBudget budget(kBudgetMs);
    const Frames frames = draw(budget, 200, {}, {}, 0.05, [](int i, Scene& scene, Machine&) {
        const double of[] = {1, 10, 0.3, 5, 0.1, 30};
        scene.splats_at_1px = 200e3 * of[i / 3 % 6];
        scene.overdraw_px = 1e6 + 0.5e6 * (i / 3 % 4);
        scene.cold = i % 3 == 0 ? 0.7 : 0;
    });
    EXPECT_GE(frames.share_within(kTolerance * kBudgetMs), 0.98);
    EXPECT_GE(frames.median_ms(), 0.85 * kBudgetMs);
}

TEST(FrameBudget, HoldsNearlyAllFramesOfANoisyMachine) {
    for (const double noise : {0.03, 0.1, 0.2}) {
        FrameBudget budget(kBudgetMs);
        Machine machine;
        machine.noise = noise;
        const Frames frames = draw(budget, 600, {}, machine);
        EXPECT_GE(frames.share_within(kTolerance * kBudgetMs), 0.94) << noise;
        EXPECT_GE(frames.median_ms(), (0.95 - 1.6 * noise) * kBudgetMs) << noise;
    }
}

TEST(FrameBudget, TakesLittleNoticeOfSingleSlowFrames) {
    FrameBudget budget(kBudgetMs);
    Machine machine;
    machine.hiccups = 0.03, machine.hiccup_ms = 300;
    const Frames frames = draw(budget, 400, {}, machine);
    EXPECT_GE(frames.share_within(kTolerance * kBudgetMs), 0.95);
    EXPECT_GE(frames.median_ms(), 0.7 * kBudgetMs);
}

// Another job takes half of the machine, and ends.
TEST(FrameBudget, FollowsAMachineThatChangesItsSpeed) {
    FrameBudget budget(kBudgetMs);
    const Frames frames = draw(budget, 150, {}, {}, 0.05, [](int i, Scene&, Machine& machine) {
        machine.slower = i < 50 || i >= 100 ? 1 : 2;
    });
    const auto slowest = [&](int from, int to) {
        return *std::max_element(frames.ms.begin() + from, frames.ms.begin() + to);
    };
    EXPECT_LE(slowest(0, 50), kTolerance * kBudgetMs);
    EXPECT_LE(slowest(56, 150), kTolerance * kBudgetMs) << "six frames after the step";
    EXPECT_GE(frames.ms[115], 0.75 * kBudgetMs) << "fifteen frames after the end";
}

TEST(FrameBudget, PicksUpFromTheTimeOfANearlyEmptyView) {
    FrameBudget budget(kBudgetMs);
    const Frames frames = draw(budget, 90, {}, {}, 0.05, [](int i, Scene& scene, Machine&) {
        scene.splats_at_1px = i >= 30 && i < 60 ? 0 : 200e3;
        scene.overdraw_px = i >= 30 && i < 60 ? 0 : 1.5e6;
    });
    EXPECT_EQ(frames.share_within(kTolerance * kBudgetMs), 1);
    EXPECT_GE(frames.ms[75], 0.8 * kBudgetMs);
}

// Below what the frame itself costs nothing helps: not the coarsest picture of all, but one that costs
// little.
TEST(FrameBudget, StaysUsefulBelowTheCostOfTheCoarsestCut) {
    for (const double budget_ms : {1e-3, 0.1, 1.0}) {
        FrameBudget budget(budget_ms);
        Scene scene;
        const Frames frames = draw(budget, 100, scene, {});
        const double coarsest_ms = Machine().draw_ms(size_of(scene, 1e9));
        for (size_t i = 20; i < 100; ++i) {
            EXPECT_LE(frames.ms[i], 1.2 * coarsest_ms) << budget_ms;
            EXPECT_LE(frames.threshold_px[i], 500) << budget_ms;
        }
    }
}

TEST(FrameBudget, FindsTheFinestCutWhereTimeDoesNotMatter) {
    FrameBudget budget(1e12);
    const Frames frames = draw(budget, 3, {}, {}, 0);
    for (const double threshold_px : frames.threshold_px) EXPECT_EQ(threshold_px, 0);
}

TEST(CostModel, PredictsWhatItLearnt) {
    scene::CostModel costs;
    Machine machine;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(0, 1);
    CutSize size;
    for (int i = 0; i < 200; ++i) {
        size = {1e6 * any(random), 0, 4e5 * any(random), 4e6 * any(random)};
        size.cold_nodes = size.nodes * any(random);
        costs.learn(size, machine.draw_ms(size));
    }
    EXPECT_NEAR(costs.predict_ms(size), machine.draw_ms(size), 0.05 * machine.draw_ms(size));
}

TEST(CostModel, GivesNothingForFree) {
    scene::CostModel costs;
    for (int i = 0; i < 200; ++i) costs.learn({1e6, 1e6, 1e6, 1e6}, 0);
    EXPECT_GT(costs.predict_ms({1e6, 0, 0, 0}), 0);
    EXPECT_GT(costs.predict_ms({0, 0, 1e6, 0}), 0);
    EXPECT_TRUE(std::isfinite(costs.most_splats(1)));
}
