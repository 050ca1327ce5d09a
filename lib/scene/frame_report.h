// One line of a frame report: what a frame cost and how wrong it is.  The keys are those of
// frame-report(5).
#pragma once

#include <optional>
#include <string>

#include "core/json.h"
#include "scene/budget_painter.h"
#include "scene/draw.h"
#include "scene/reference.h"
#include "scene/stream.h"

namespace scene {

// One of several drawings of a camera.
struct RefinementReport {
    int number = 0;         // from 0
    double elapsed_ms = 0;  // with those before it
};

struct FrameReport {
    int frame = 0;      // from 0, as in the pictures' names
    std::string eye{};  // "left" or "right" where there are two
    double time_s = 0;
    std::string backend{};  // its name
    splat::CutOptions cut;
    DrawReport draw;
    double write_ms = 0;      // waiting for the writer, which works behind the renderer
    double reference_ms = 0;  // drawing the reference and measuring; not part of the total
    std::optional<ReferenceMeasures> reference{};
    std::optional<BudgetReport> budget{};
    std::optional<RefinementReport> refinement{};
    std::optional<StreamReport> stream{};

    // What is held to a budget.
    double drawing_ms() const { return (budget ? budget->predict_ms : 0) + draw.traverse_ms + draw.draw_ms; }
    double total_ms() const { return drawing_ms() + write_ms; }

    // What was drawn may be further off than was asked for: there was nothing finer.  Never with a threshold
    // of 0, which asks for all there is, or one on diameters.
    bool misses_threshold() const {
        constexpr double kRounding = 1 + 1e-6;
        return cut.by == splat::CutBy::error && cut.threshold_px > 0 &&
               draw.counts.error_bound_px > kRounding * cut.threshold_px;
    }
};

// Appends the keys of a measured frame.
void add_reference(core::Json& json, const ReferenceMeasures& measures);

// Infinite measures become null when they are written.
core::Json to_json(const FrameReport& report);

// The line of a frame that could not be drawn.
core::Json to_json_of_failure(int frame, const std::string& error);

}  // namespace scene
