#include "scene/draw.h"

#include <chrono>
#include <limits>
#include <utility>

#include "core/parallel.h"
#include "core/stopwatch.h"

namespace scene {

ModelPainter::ModelPainter(const splat::Model& model, std::unique_ptr<render::SplatPainter> painter)
    : model_(model), cut_(model), painter_(std::move(painter)) {}

DrawReport ModelPainter::draw(const geom::View& view, const DrawOptions& options, render::Frame& frame) {
    DrawReport report;
    core::Stopwatch watch;
    const size_t tasks = cut_.begin(view, options.cut);
    const bool has_colour = model_.header().flags & (splat::kHasColour | splat::kConstantColour);
    painter_->begin(
        view, {options.kind, options.shade, has_colour, options.background, model_.header().scale}, tasks);
    core::parallel_for(tasks, [&](size_t task) {
        cut_.run(task, [&](const geom::SplatBatch& batch) { painter_->add(task, batch); });
        painter_->end_task(task);
    });
    report.traverse_ms = watch.lap_ms();
    painter_->finish(frame);
    report.draw_ms = watch.lap_ms();
    report.counts = cut_.counts();
    // The bound is that of the ellipsoids.  A square or a disc that faces the screen reaches beyond its own.
    if (options.kind == render::SplatKind::square || options.kind == render::SplatKind::circle)
        report.counts.error_bound_px = std::numeric_limits<double>::infinity();
    return report;
}

}  // namespace scene
