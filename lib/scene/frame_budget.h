// Holding the time of a frame: which threshold to draw a view at, so that it is done within a budget.
//
// The original (Streaming QSplat, section 3.1) adjusts the threshold by the time of the frame before.  That
// is late by a frame wherever the view changes, and has nothing to go by in the first.  Here the time of a
// cut is predicted from what it holds, which a profile of the view (splat/cut_profile.h) tells for all
// thresholds, and the feedback corrects the prediction: a recursive least-squares fit, which follows a
// machine that grows slower or faster. As there, steps are bounded: what one frame can teach, and by how much
// the number of splats may differ from that of the frame before.  (Not the threshold, which must change with
// the view for the splats to stay the same.)
//
// Pure: no clock is read here.
#pragma once

#include <array>

#include "splat/cut_profile.h"

namespace scene {

// Milliseconds of a frame: a sum of costs of the frame itself, and of each node, first use of a node, splat
// and pixel.
class CostModel {
  public:
    CostModel();

    double predict_ms(const splat::CutSize& size) const;
    void learn(const splat::CutSize& size, double measured_ms);

    // How far off a prediction of a frame like the last one may be: a standard deviation, by the prediction.
    double deviation() const { return deviation_; }

    // At most this many splats can be drawn in the time, if nothing else cost any.
    double most_splats(double ms) const;

  private:
    static constexpr size_t kTerms = 5;
    using Terms = std::array<double, kTerms>;
    static Terms terms_of(const splat::CutSize& size);
    static double product(const Terms& a, const Terms& b);
    Terms carried_by(const Terms& terms) const;  // covariance times terms

    // Of each term: how many times the guess it really costs; and the covariance of these.
    Terms factor_;
    std::array<Terms, kTerms> covariance_{};
    double variance_;  // of the time of a frame about what the factors say, by its time
    double deviation_;
};

class FrameBudget {
  public:
    static constexpr double kTolerance = 1.2;  // up to so many budgets a frame is in time

    // Throws core::Error where the budget is not above 0.
    explicit FrameBudget(double budget_ms);

    struct Choice {
        double threshold_px = 0;
        double predicted_ms = 0;
        splat::CutSize size;  // expected
    };

    // The first frames are trials: at parts of the budget, growing, to learn how fast the machine is.
    bool is_trial() const { return frames_ < kTrialShares.size(); }

    // What to ask for, for a profile that is worth its time.
    splat::ProfileOptions profile_options(double finest_px) const;

    // The finest cut that is predicted to be drawn in time; never finer than the profile's finest.
    // `spent_ms`: of the frame's time, for the profile.  Where no cut is in time, the finest of those that
    // cost nearly the least: a coarser one would not help.
    Choice choose(const splat::CutProfile& profile, double spent_ms) const;

    // How long a frame drawn as chosen took, without what was spent before.
    void learn(const Choice& choice, double measured_ms);

    double budget_ms() const { return budget_ms_; }

  private:
    // Nothing is learnt from the first one, which makes threads and whatever else is made once.  The last one
    // is as large as a frame: memory that is used for the first time costs as much as drawing.
    static constexpr std::array<double, 5> kTrialShares = {0.125, 0.125, 0.25, 0.5, 1};

    double aim_ms() const;

    double budget_ms_;
    CostModel costs_;
    size_t frames_ = 0;       // drawn
    double last_splats_ = 0;  // expected of the last frame
};

}  // namespace scene
