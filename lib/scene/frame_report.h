// One line of a frame report: what a frame cost and how wrong it is.  The keys are those of
// frame-report(5).
#pragma once

#include <optional>

#include "core/program.h"
#include "scene/draw.h"
#include "scene/reference.h"

namespace scene {

struct FrameReport {
    int frame = 0;  // from 0, as in the pictures' names
    double time_s = 0;
    splat::CutOptions cut;
    DrawReport draw;
    double write_ms = 0;      // waiting for the writer, which works behind the renderer
    double reference_ms = 0;  // drawing the reference and measuring; not part of the total
    std::optional<ReferenceMeasures> reference{};
};

// Infinite measures become null when they are written.
core::Json to_json(const FrameReport& report, const splat::Model& model);

}  // namespace scene
