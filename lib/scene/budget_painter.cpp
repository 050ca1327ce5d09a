#include "scene/budget_painter.h"

#include "core/stopwatch.h"

namespace scene {

BudgetPainter::BudgetPainter(ModelPainter& painter, double budget_ms)
    : painter_(painter), budget_(budget_ms) {}

DrawReport BudgetPainter::draw(const geom::View& view, DrawOptions& options, render::Frame& frame) {
    while (budget_.is_trial()) {
        DrawOptions trial = options;
        draw_once(view, trial, frame);
    }
    return draw_once(view, options, frame);
}

DrawReport BudgetPainter::draw_once(const geom::View& view, DrawOptions& options, render::Frame& frame) {
    core::Stopwatch watch;
    const splat::CutProfile profile =
        painter_.profile(view, options.cut, budget_.profile_options(options.cut.threshold_px));
    const double predict_ms = watch.lap_ms();
    const FrameBudget::Choice choice = budget_.choose(profile, predict_ms);
    options.cut.threshold_px = choice.threshold_px;
    report_ = {budget_.budget_ms(), predict_ms + choice.predicted_ms, predict_ms, choice.threshold_px};
    const DrawReport drawn = painter_.draw(view, options, frame);
    budget_.learn(choice, drawn.traverse_ms + drawn.draw_ms);
    return drawn;
}

}  // namespace scene
