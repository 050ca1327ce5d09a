#include "scene/draw.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>

#include "core/parallel.h"
#include "core/stopwatch.h"
#include "scene/seen_error.h"
#include "splat/walk.h"

namespace scene {

namespace {

// Of the first outline's nodes, a part of this size must be hidden.  Ten times as much would leave out a
// quarter of a CT head's splats along two of its paths, which are a third by this; a second bound, on what
// the second outline hides, tells more, but to go back after it costs what it saves (scripts/bench:
// occlusion).
constexpr double kLeastHidden = 0.0015;

}  // namespace

geom::Sphere bounds_of(std::span<const PlacedModel> models) {
    geom::Sphere all = models[0].bounds();
    for (const PlacedModel& model : models.subspan(1)) all = geom::sphere_around(all, model.bounds());
    return all;
}

std::vector<geom::Sphere> outline_of(std::span<const PlacedModel> models) {
    std::vector<geom::Sphere> spheres;
    for (const PlacedModel& placed : models) {
        const splat::Header& header = placed.model->header();
        splat::walk_cut(*placed.model, kOutlineLevel, [&](const splat::Node& node) {
            const geom::Sphere sphere{header.origin + header.scale * node.centre,
                                      header.scale * double((1 + splat::kSlack) * node.radius)};
            spheres.push_back(geom::placed(sphere, placed.world_from_model));
        });
    }
    return spheres;
}

ModelPainter::ModelPainter(const std::vector<PlacedModel>& models, Painter painter)
    : painter_(std::move(painter)), prover_(dynamic_cast<render::Splatter*>(painter_.get())) {
    for (const PlacedModel& placed : models) {
        const splat::Header& header = placed.model->header();
        const double scale = header.scale * placed.world_from_model.scale;
        parts_.push_back({placed, std::make_unique<splat::Cut>(*placed.model), scale});
        largest_ = std::max(largest_, scale);
        has_colour_ = has_colour_ || header.flags & (splat::kHasColour | splat::kConstantColour);
    }
    unit_ = largest_;
}

template <class Body>
void ModelPainter::for_tasks(const Body& body) {
    core::parallel_for(task_count_, [&](size_t task) {
        const auto after = [](size_t t, const Part& part) { return t < part.first_task; };
        Part& part = *(std::upper_bound(parts_.begin(), parts_.end(), task, after) - 1);
        body(part, task - part.first_task, task);
    });
}

bool ModelPainter::may_have_triangles(const DrawOptions& options) const {
    return std::any_of(parts_.begin(), parts_.end(), [&](const Part& part) {
        return part.placed.model->header().has_triangles() && splat::hands_out_triangles(options.cut);
    });
}

render::SplatterOptions ModelPainter::splatter_options(const DrawOptions& options) const {
    // Where splats are coarser than the least push-back, their rims are further from the surface.
    const double push_back_px = std::max(render::kPushBackPx, options.cut.threshold_px);
    return {options.kind, options.look, has_colour_ || options.cut.last_number,
            unit_,        push_back_px, may_have_triangles(options)};
}

void ModelPainter::begin(const geom::View& view, const DrawOptions& options) {
    task_count_ = 0;
    unit_ = unit_for(view);
    for (Part& part : parts_) {
        part.first_task = task_count_;
        task_count_ += part.cut->begin(geom::view_in(part.placed.world_from_model, view), options.cut,
                                       part.scale / unit_);
    }
    painter_->begin(view, splatter_options(options), task_count_);
}

// The splatter tells cores from covers by their depths, which are right up to 6e4 units.
double ModelPainter::unit_for(const geom::View& view) const {
    constexpr double kFarthest = 0x1p15;
    double unit = largest_;
    for (const Part& part : parts_) {
        const geom::Sphere bounds = part.placed.bounds();
        const double farthest = glm::dot(bounds.centre - view.eye, view.forward) + bounds.radius;
        // By powers of two: they change no bit of a picture.
        while (farthest > kFarthest * unit) unit *= 2;
    }
    return unit;
}

// Shows the map the models' next levels, and looks at their nodes.
splat::Cut::Sifted ModelPainter::outline() {
    for_tasks([&](Part& part, size_t task, size_t) { part.cut->outline(task, map_); });
    map_.build();
    std::atomic<size_t> waiting{0}, hidden{0};
    for_tasks([&](Part& part, size_t task, size_t) {
        const splat::Cut::Sifted sifted = part.cut->sift(task, map_);
        waiting += sifted.waiting, hidden += sifted.hidden;
    });
    return {waiting, hidden};
}

// Whether what the map hides is to be left out.
bool ModelPainter::finds_hidden(const geom::View& view, const DrawOptions& options) {
    const Occlusion occlusion = options.occlusion;
    if (occlusion == Occlusion::off || !prover_) return false;
    // The map's blocks are of pixels, the splatter's of samples.
    if (options.look.samples_across > 1) return false;
    if (occlusion == Occlusion::automatic && !choice_.is_due()) return false;
    map_.begin(view, unit_);
    const splat::Cut::Sifted first = outline();
    const bool is_little = first.hidden == 0 || double(first.hidden) < kLeastHidden * double(first.waiting);
    if (occlusion == Occlusion::automatic && is_little) {
        choice_.note(false);
        return false;
    }
    const splat::Cut::Sifted second = outline();
    gain_ = {second.waiting, double(second.hidden) / double(std::max<size_t>(1, second.waiting))};
    return true;
}

void ModelPainter::walk(geom::OcclusionMap* map) {
    for_tasks([&](Part& part, size_t part_task, size_t task) {
        part.cut->run(
            part_task, [&](const geom::SplatBatch& batch) { painter_->add(task, batch); }, map,
            [&](const geom::TriangleBatch& batch) { painter_->add(task, batch); });
        painter_->end_task(task);
    });
}

// What was walked with the map.
void ModelPainter::finish_hidden(const geom::View& view, const DrawOptions& options, render::Frame& frame) {
    gain_.splats = report().counts.splats;
    prover_->finish(frame, map_);
    if (map_.has_unproven()) repeat_unproven(view, options, frame);
    gain_.redrawn = report().counts.splats - gain_.splats;
    choice_.note(gain_.paid());
}

void ModelPainter::repeat_unproven(const geom::View& view, const DrawOptions& options, render::Frame& frame) {
    map_.begin_repeat();
    prover_->begin(view, splatter_options(options), task_count_);
    walk(&map_);
    prover_->finish(frame, map_);
}

DrawReport ModelPainter::draw(const geom::View& view, const DrawOptions& options, render::Frame& frame) {
    core::Stopwatch watch;
    begin(view, options);
    const bool leaves_out = finds_hidden(view, options);
    walk(leaves_out ? &map_ : nullptr);
    const double traverse_ms = watch.lap_ms();
    leaves_out ? finish_hidden(view, options, frame) : painter_->finish(frame);
    DrawReport done = report();
    done.traverse_ms = traverse_ms;
    done.draw_ms = watch.lap_ms();
    // The bound is that of the ellipsoids.  A square or a disc that faces the screen reaches beyond its own.
    if (options.kind == render::SplatKind::square || options.kind == render::SplatKind::circle)
        done.counts.error_bound_px = std::numeric_limits<double>::infinity();
    else if (options.look.samples_across == 1)
        done.counts.error_bound_px = seen_error_px(done.counts, unit_, view, frame);
    return done;
}

std::vector<ModelPlan> ModelPainter::plans() const {
    std::vector<ModelPlan> plans;
    for (const Part& part : parts_) plans.push_back({part.placed.model, part.cut->plan()});
    return plans;
}

splat::CutProfile ModelPainter::profile(const geom::View& view, const splat::CutOptions& options,
                                        const splat::ProfileOptions& limits) const {
    const auto of = [&](const Part& part) {
        return part.cut->profile(geom::view_in(part.placed.world_from_model, view), options, limits);
    };
    splat::CutProfile sum = of(parts_[0]);
    for (size_t i = 1; i < parts_.size(); ++i) sum.add(of(parts_[i]));
    return sum;
}

DrawReport ModelPainter::report() const {
    DrawReport sum;
    for (const Part& part : parts_) {
        const splat::Model& model = *part.placed.model;
        const splat::CutCounts counts = part.cut->counts();
        sum.counts.add(counts);
        sum.bytes_touched += counts.blocks_touched * model.header().block_size;
        sum.model_blocks += model.header().block_count;
        sum.model_blocks_present += model.blocks_present();
    }
    return sum;
}

}  // namespace scene
