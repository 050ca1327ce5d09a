// Drawing a model in a given time: ModelPainter led by FrameBudget.
#pragma once

#include "scene/draw.h"
#include "scene/frame_budget.h"

namespace scene {

struct BudgetReport {
    double budget_ms = 0;
    double predicted_ms = 0;  // choosing the threshold, and drawing
    double predict_ms = 0;    // choosing the threshold
    double threshold_px = 0;  // chosen
};

class BudgetPainter {
  public:
    BudgetPainter(ModelPainter& painter, double budget_ms);  // the painter lives longer

    // Draws at a threshold of options.cut.threshold_px or more, so that the time of choosing and drawing
    // keeps to the budget; writes the threshold to options.cut.  Before the first frame its view is drawn on
    // trial, for some two budgets in all, to learn how fast the machine is.
    DrawReport draw(const geom::View& view, DrawOptions& options, render::Frame& frame);

    const BudgetReport& report() const { return report_; }  // of the last frame

  private:
    DrawReport draw_once(const geom::View& view, DrawOptions& options, render::Frame& frame);

    ModelPainter& painter_;
    FrameBudget budget_;
    BudgetReport report_;
};

}  // namespace scene
