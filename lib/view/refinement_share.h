// How far a refinement has come.
#pragma once

#include <algorithm>
#include <cmath>

#include "scene/refinement.h"

namespace view {

// From 0, at a threshold of scene::kFirstRefinementPx and more, to 1, at the last one: equal steps are equal
// shares.
inline double refinement_share(double threshold_px, double last_px) {
    const double last = std::max(last_px, 1.0 / 64);
    if (threshold_px <= last) return 1;
    if (last >= scene::kFirstRefinementPx) return 0;
    return std::clamp(
        std::log(scene::kFirstRefinementPx / threshold_px) / std::log(scene::kFirstRefinementPx / last), 0.0,
        1.0);
}

}  // namespace view
