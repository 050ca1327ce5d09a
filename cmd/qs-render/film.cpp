#include "qs-render/film.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "core/messages.h"
#include "core/stopwatch.h"
#include "mesh/mesh.h"
#include "scene/refinement.h"

namespace qs_render {

using core::text;
using scene::Models;

namespace {

std::unique_ptr<scene::Reference> reference_of(const Arguments& a, const Models& models) {
    if (a.reference.empty()) return nullptr;
    const bool has_colour = models.has_colour();
    auto reference =
        std::make_unique<scene::Reference>(mesh::read_mesh(a.reference).mesh, a.reference, has_colour);
    if (has_colour && !reference->has_colour())
        core::warn(a.reference + ": has no colours, unlike the model; its frames are grey");
    return reference;
}

// On a machine that does nothing else no more frames than this part are late (qs-render(1)).
constexpr double kLateFramesPromised = 0.05;

// Why a frame cannot be drawn, as opposed to written.
struct Undrawable : core::Error {
    using core::Error::Error;
};

template <class Draw>
auto or_undrawable(const Draw& draw) {
    try {
        return draw();
    } catch (const core::Error& error) {
        throw Undrawable(error.what());
    }
}

}  // namespace

void check_occlusion(const scene::DrawOptions& draw, const scene::ModelPainter& painter,
                     const std::string& backend) {
    if (draw.occlusion == scene::Occlusion::on && !painter.can_hide())
        throw core::UsageError("--occlusion on: only the back end cpu can leave out what is hidden, not " +
                               backend);
}

Film::Film(const Arguments& arguments, const scene::DrawOptions& options, const Models& models,
           const std::vector<std::string>& inputs, double frames_per_s, scene::Backend backend)
    : a_(arguments),
      options_(options),
      screen_(screen(arguments)),
      are_complete_(models.are_complete()),
      report_(inputs, {}),  // scene::check() knows the outputs, frame by frame
      files_(arguments.output, format_of(arguments), frames_per_s, arguments.depth),
      reference_(reference_of(arguments, models)),
      backend_(backend.name),
      painter_(models.placed(), std::move(backend.painter)) {
    check_occlusion(options, painter_, backend_);
    if (a_.has_budget()) budget_painter_.emplace(painter_, a_.budget_ms);
}

void Film::expect(const geom::PathFrame& shot) {
    if (!shot.fault.empty()) return;  // which take() tells
    std::vector<geom::View> views;
    for (const scene::EyeView& eye : scene::views_of(shot.camera, screen_)) views.push_back(eye.view);
    stream_->show(std::move(views), options_);
}

void Film::take(int number, const geom::PathFrame& shot) {
    try {
        // Both eyes are drawn before anything is written, so that a frame that fails leaves nothing.
        for (Picture& picture : draw_eyes(number, shot)) write(picture);
    } catch (const Undrawable& error) {
        if (!a_.keep_going) throw;
        core::fail(text("frame %d: %s", number, error.what()));
        report_.write(scene::to_json_of_failure(number, error.what()));
    }
}

std::span<Film::Picture> Film::draw_eyes(int number, const geom::PathFrame& shot) {
    if (!shot.fault.empty()) throw Undrawable(shot.fault);
    const auto views = or_undrawable([&] { return scene::views_of(shot.camera, screen_); });
    if (stream_) begin_streaming(number, views);
    for (size_t i = 0; i < views.size(); ++i) {
        scene::FrameReport line;
        line.frame = number;
        line.eye = views[i].eye;
        line.time_s = shot.camera.time_s;
        line.backend = backend_;
        line.cut = options_.cut;
        draw_again_and_again(views[i].view, std::move(line), pictures_[i]);
    }
    const auto pictures = std::span(pictures_).first(views.size());
    if (stream_) end_streaming(pictures);
    return pictures;
}

void Film::begin_streaming(int number, const std::vector<scene::EyeView>& views) {
    std::vector<geom::View> shown;
    for (const scene::EyeView& view : views) shown.push_back(view.view);
    std::optional<double> time_s;
    if (a_.streaming.is_realtime()) time_s = number / a_.streaming.realtime_fps;
    stream_->show(std::move(shown), options_, time_s);
    if (a_.streaming.settles()) stream_->settle(painter_);
}

void Film::end_streaming(std::span<Picture> pictures) {
    scene::DrawReport drawn;
    for (const Picture& picture : pictures) drawn.counts.add(picture.lines.back().draw.counts);
    const scene::StreamReport report = stream_->look(painter_, drawn);
    for (Picture& picture : pictures) picture.lines.back().stream = report;
    unsettled_count_ += report.visible_blocks_missing > 0;
    cut_short_count_ += report.visible_blocks_missing > 0 && report.is_budget_used;
}

void Film::draw_again_and_again(const geom::View& view, scene::FrameReport line, Picture& picture) {
    picture.lines.clear();
    line.cut.threshold_px = options_.cut.threshold_px;
    if (a_.refine) line.cut.threshold_px = std::max(line.cut.threshold_px, scene::kFirstRefinementPx);
    double elapsed_ms = 0;
    for (int refinement = 0;; ++refinement) {
        or_undrawable([&] { draw(view, refinement == 0, line, picture.frame); });
        elapsed_ms += line.total_ms();
        if (a_.refine) line.refinement = {refinement, elapsed_ms};
        if (reference_) measure(view, line, picture.frame);
        picture.lines.push_back(line);
        if (!a_.refine) return;
        const std::optional<double> finer =
            scene::refined_threshold(line.cut.threshold_px, options_.cut.threshold_px, line.draw.counts);
        if (!finer) return;
        line.cut.threshold_px = *finer;
    }
}

void Film::draw(const geom::View& view, bool is_first, scene::FrameReport& line, render::Frame& frame) {
    scene::DrawOptions options = options_;
    line.budget.reset();
    if (budget_painter_ && is_first) {
        line.draw = budget_painter_->draw(view, options, frame);
        line.budget = budget_painter_->report();
        line.cut = options.cut;
    } else {
        options.cut = line.cut;
        line.draw = painter_.draw(view, options, frame);
    }
}

void Film::measure(const geom::View& view, scene::FrameReport& line, const render::Frame& frame) {
    core::Stopwatch watch;
    line.reference = reference_->measure(view, options_.look, frame);
    line.reference_ms = watch.lap_ms();
    ++measured_count_;
    beyond_bound_count_ +=
        line.reference->measured_error_px > line.draw.counts.error_bound_px + scene::rounding_px(view);
}

// Of a picture that was refined, the last drawing.
void Film::write(Picture& picture) {
    scene::FrameReport& last = picture.lines.back();
    core::Stopwatch watch;
    files_.write(last.frame, last.eye, picture.frame);
    last.write_ms = watch.lap_ms();
    if (last.refinement) last.refinement->elapsed_ms += last.write_ms;
    if (report_.is_wanted())
        for (const scene::FrameReport& line : picture.lines) report_.write(scene::to_json(line));
    count(last);
}

void Film::count(scene::FrameReport line) {
    ++drawn_count_;
    empty_count_ += line.draw.counts.splats + line.draw.counts.triangles == 0;
    fastest_ms_ = std::min(fastest_ms_, line.drawing_ms());
    late_count_ += line.budget && line.drawing_ms() > scene::FrameBudget::kTolerance * a_.budget_ms;
    // The default is a wish that small models cannot meet; squares and circles have no bound to hold against
    // it; of a prefix has been warned; and a budget may have asked for less.
    const bool is_bounded =
        options_.kind == render::SplatKind::ellipse || options_.kind == render::SplatKind::smooth;
    const bool was_asked = a_.threshold_is_given() && are_complete_ && is_bounded &&
                           (a_.refine || line.cut.threshold_px <= options_.cut.threshold_px);
    line.cut = options_.cut;
    coarse_count_ += was_asked && line.misses_threshold();
}

void Film::finish() {
    files_.finish();
    report_.commit();
    if (coarse_count_ > 0)
        core::warn(text("threshold %g px not met in %zu of %zu frames: the model's leaves are coarser",
                        options_.cut.threshold_px, coarse_count_, drawn_count_));
    if (beyond_bound_count_ > 0)
        core::warn(text(
            "%s: errors are above the bound in %zu of %zu drawings: not the mesh that the model was made of",
            a_.reference.c_str(), beyond_bound_count_, measured_count_));
    if (empty_count_ > 0 && empty_count_ == drawn_count_ && !stream_)
        core::warn(
            "nothing of the model is in any picture, between its near and far: qs-info says where it is "
            "(origin) "
            "and how large (scale)");
    if (a_.has_budget()) say_how_budget_was_held();
    if (cut_short_count_ > 0)
        core::warn(
            text("--byte-budget of %llu bytes is used up: %llu of %zu frames lack blocks that can be seen",
                 static_cast<unsigned long long>(a_.streaming.byte_budget),
                 static_cast<unsigned long long>(cut_short_count_), drawn_count_));
    else if (unsettled_count_ > 0 && !a_.streaming.draws_at_once())
        core::warn(text("%llu of %zu frames lack blocks that can be seen and did not come",
                        static_cast<unsigned long long>(unsettled_count_), drawn_count_));
}

void Film::say_how_budget_was_held() const {
    const std::string late = text("%zu of %zu frames took more than %g times as long", late_count_,
                                  drawn_count_, scene::FrameBudget::kTolerance);
    if (double(late_count_) <= kLateFramesPromised * double(drawn_count_))
        core::notice(text("budget %g ms: ", a_.budget_ms) + late);
    else
        core::warn(text("budget %g ms not held: ", a_.budget_ms) + late +
                   text("; the fastest took %.2g ms", fastest_ms_));
}

}  // namespace qs_render
