// The threshold that keeps frames in their time, by the time of the frame before (Streaming QSplat,
// section 3.1): for what has no profile to predict it from.
#pragma once

#include <algorithm>
#include <cmath>

namespace view {

class Feedback {
  public:
    // To draw with.
    double threshold_px(double last_px) const { return std::max(threshold_px_, last_px); }

    // What a frame drawn with `threshold_px` took.  The number of triangles goes with about the threshold's
    // inverse square, so its root is taken; and a frame changes the next one's threshold by a factor of 2 at
    // most.
    void learn(double threshold_px, double measured_ms, double budget_ms) {
        const double factor = std::sqrt(std::max(measured_ms, 1e-3) / budget_ms);
        threshold_px_ = std::clamp(threshold_px * std::clamp(factor, 0.5, 2.0), kFinestPx, kCoarsestPx);
    }

  private:
    static constexpr double kFinestPx = 1.0 / 64, kCoarsestPx = 256;
    double threshold_px_ = 8;
};

}  // namespace view
