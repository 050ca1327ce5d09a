// Drawing one view again and again, finer each time, as a viewer does while nobody moves (Streaming QSplat,
// section 3.1: "progressively smaller thresholds, until we either descend to the leaves of the tree or reach
// a splat size of one pixel").
#pragma once

#include <optional>

#include "splat/cut.h"

namespace scene {

// The first threshold where no budget says one: draws in a few milliseconds whatever the model.
constexpr double kFirstRefinementPx = 32;

// From one threshold to the next; a cut then holds some 1.6 times as many splats, so that all cuts before the
// last together cost less than two of it.  The original's factor.
constexpr double kRefinementFactor = 0.70710678118654752;

// The threshold to draw with after a cut at `threshold_px`; none where that was the last one, being at most
// `last_px`, or where nothing finer is there.
std::optional<double> refined_threshold(double threshold_px, double last_px, const splat::CutCounts& drawn);

}  // namespace scene
