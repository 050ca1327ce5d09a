#include "scene/frame_budget.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace scene {

namespace {

// First guesses, ms: a frame of 1280 x 720 pixels; a node, its first use, a splat, a pixel of one.  Two
// threads of 2021; what is wrong by the same factor for all of them is found with the first frame.
constexpr std::array<double, 5> kGuess = {1, 10e-6, 25e-6, 15e-6, 1.5e-6};
constexpr double kSpeedDeviation = 2, kTermDeviation = 0.4;  // of the guesses, by the guess
constexpr double kLeastFactor = 0.02;                        // no term is free

constexpr double kSpeedDrift = 0.05, kTermDrift = 0.02;  // from frame to frame, standard deviations
constexpr double kFirstNoise = 0.08, kLeastNoise = 0.02, kMostNoise = 0.25;
constexpr double kClockNoiseMs = 0.2;
constexpr double kNoiseMemory = 0.95;
constexpr double kLargestStep = 0.4;  // by which one frame may surprise, by the prediction

// A frame is in time up to kTolerance budgets; 95 % of frames take at most kNoises deviations more than
// predicted (1.65 where times are distributed normally; theirs have a longer tail).
constexpr double kNoises = 2, kLargestAim = 0.95;

constexpr double kLargestStepOfSplats = 2;  // from a frame to the next
constexpr double kFewSplats = 10e3;         // any frame may have so many
constexpr double kNearlyLeast = 1.1;  // what cannot be in time may cost this much more than the cheapest
constexpr double kMarginOfSplats = 1.5;
constexpr double kSamplesPerMs = 32;  // a profile then takes some 4 % of the budget

}  // namespace

CostModel::CostModel() : variance_(kFirstNoise * kFirstNoise), deviation_(kFirstNoise) {
    factor_.fill(1);
    for (size_t i = 0; i < kTerms; ++i)
        for (size_t k = 0; k < kTerms; ++k)
            covariance_[i][k] =
                kSpeedDeviation * kSpeedDeviation + (i == k ? kTermDeviation * kTermDeviation : 0);
}

CostModel::Terms CostModel::terms_of(const splat::CutSize& size) {
    return {kGuess[0], kGuess[1] * size.nodes, kGuess[2] * size.cold_nodes, kGuess[3] * size.splats,
            kGuess[4] * size.pixels};
}

double CostModel::product(const Terms& a, const Terms& b) {
    double sum = 0;
    for (size_t i = 0; i < kTerms; ++i) sum += a[i] * b[i];
    return sum;
}

CostModel::Terms CostModel::carried_by(const Terms& terms) const {
    Terms carried;
    for (size_t i = 0; i < kTerms; ++i) carried[i] = product(covariance_[i], terms);
    return carried;
}

double CostModel::predict_ms(const splat::CutSize& size) const {
    return product(factor_, terms_of(size));
}

double CostModel::most_splats(double ms) const {
    return ms / (factor_[1] * kGuess[1] + factor_[3] * kGuess[3]);
}

// A Kalman filter whose state drifts.
void CostModel::learn(const splat::CutSize& size, double measured_ms) {
    const Terms terms = terms_of(size);
    const double predicted_ms = predict_ms(size);
    const Terms carried = carried_by(terms);
    const double spread = product(terms, carried);
    const double noise_ms = std::sqrt(variance_) * predicted_ms + kClockNoiseMs;
    const double total = spread + noise_ms * noise_ms;
    const double largest = std::max(kLargestStep * predicted_ms, 2 * std::sqrt(total));
    const double surprise = std::clamp(measured_ms - predicted_ms, -largest, largest);

    // Of a surprise, the share of noise is that which it has in what was expected.
    const double unexplained = surprise * surprise / total * noise_ms * noise_ms;
    variance_ = std::clamp(
        kNoiseMemory * variance_ + (1 - kNoiseMemory) * unexplained / (predicted_ms * predicted_ms),
        kLeastNoise * kLeastNoise, kMostNoise * kMostNoise);

    for (size_t i = 0; i < kTerms; ++i)
        factor_[i] = std::max(kLeastFactor, factor_[i] + carried[i] / total * surprise);
    for (size_t i = 0; i < kTerms; ++i)
        for (size_t k = 0; k < kTerms; ++k) {
            covariance_[i][k] -= carried[i] * carried[k] / total;
            covariance_[i][k] += kSpeedDrift * kSpeedDrift * factor_[i] * factor_[k];
            if (i == k) covariance_[i][k] += kTermDrift * kTermDrift * factor_[i] * factor_[i];
        }
    deviation_ = std::sqrt(product(terms, carried_by(terms)) + noise_ms * noise_ms) / predict_ms(size);
}

FrameBudget::FrameBudget(double budget_ms) : budget_ms_(budget_ms) {
    if (!(budget_ms > 0)) throw core::Error(core::text("a budget of %g ms is no time to draw in", budget_ms));
}

double FrameBudget::aim_ms() const {
    return budget_ms_ * std::min(kLargestAim, kTolerance / (1 + kNoises * costs_.deviation()));
}

splat::ProfileOptions FrameBudget::profile_options(double finest_px) const {
    return {finest_px, kMarginOfSplats * costs_.most_splats(budget_ms_),
            size_t(std::clamp(kSamplesPerMs * budget_ms_, 64.0, 1024.0))};
}

void FrameBudget::learn(const Choice& choice, double measured_ms) {
    if (frames_++ > 0) costs_.learn(choice.size, measured_ms);
    last_splats_ = std::max(choice.size.splats, kFewSplats);
}

FrameBudget::Choice FrameBudget::choose(const splat::CutProfile& profile, double spent_ms) const {
    const int first = profile.first_step();
    const auto ms = [&](int step) { return costs_.predict_ms(profile.at(step)); };
    double least_ms = ms(first);
    for (int step = first; step < splat::CutProfile::kSteps; ++step) least_ms = std::min(least_ms, ms(step));
    const double share = is_trial() ? kTrialShares[frames_] : 1;
    const double limit_ms = std::max(share * aim_ms() - spent_ms, kNearlyLeast * least_ms);
    const double most_splats = is_trial() ? HUGE_VAL : kLargestStepOfSplats * last_splats_;
    const double least_splats = is_trial() ? 0 : last_splats_ / kLargestStepOfSplats;
    // How far beyond what is allowed: 0 and below is allowed.
    const auto excess = [&](int step) {
        const double splats = profile.at(step).splats;
        if (splats < least_splats) return 0.0;
        return std::max(ms(step) / limit_ms, splats / most_splats) - 1;
    };
    int step = first;
    while (step + 1 < splat::CutProfile::kSteps && excess(step) > 0) ++step;
    Choice choice{profile.threshold_px(step), 0, profile.at(step)};
    // Between this step and the one before, which is too dear.
    if (step > first && profile.threshold_px(step - 1) >= splat::CutProfile::kFinestPx) {
        const double here = excess(step), before = excess(step - 1);
        const double part = here < 0 ? here / (here - before) : 0;
        choice.size = {};
        choice.size.add(profile.at(step), 1 - part);
        choice.size.add(profile.at(step - 1), part);
        choice.threshold_px *= std::pow(profile.threshold_px(step - 1) / profile.threshold_px(step), part);
    }
    choice.predicted_ms = costs_.predict_ms(choice.size);
    return choice;
}

}  // namespace scene
