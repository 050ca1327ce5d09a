#include "scene/refinement.h"

namespace scene {

std::optional<double> refined_threshold(double threshold_px, double last_px, const splat::CutCounts& drawn) {
    // From here on nothing more can be seen, and with a last threshold of 0 there may be many on the way.
    constexpr double kInvisiblePx = 1.0 / 64;
    if (threshold_px <= last_px || drawn.closed == 0) return {};
    const double next_px = kRefinementFactor * threshold_px;
    // What is nearly the last threshold would be drawn twice.
    return next_px < 1.1 * last_px || next_px < kInvisiblePx ? last_px : next_px;
}

}  // namespace scene
