// Splat models as they are looked at, from files and while they arrive.
#include <algorithm>
#include <limits>

#include "core/error.h"
#include "core/stopwatch.h"
#include "scene/budget_painter.h"
#include "scene/camera_options.h"
#include "scene/refinement.h"
#include "scene/stream.h"
#include "view/painter_choice.h"
#include "view/refinement_share.h"
#include "view/subject.h"

namespace view {

namespace {

constexpr double kHiddenLook_s = 0.25;
constexpr int kTrials = 3;  // drawings of a view by each back end, of which the fastest counts

// What the home view takes with a back end.
double measure_ms(const std::vector<scene::PlacedModel>& models, scene::ModelPainter& painter,
                  const SubjectOptions& options) {
    const geom::Camera camera = scene::CameraOptions().camera(
        scene::bounds_of(models), scene::outline_of(models), double(options.width) / options.height);
    const geom::View view = geom::make_view(camera, options.width, options.height);
    scene::DrawOptions draw;
    draw.kind = options.splat;
    draw.cut.triangle_px = scene::kTrianglePx;
    render::Frame frame;
    double least = std::numeric_limits<double>::infinity();
    for (int trial = 0; trial < kTrials; ++trial) {
        core::Stopwatch watch;
        painter.draw(view, draw, frame);
        least = std::min(least, watch.lap_ms());
    }
    return least;
}

class Splats final : public Subject {
  public:
    Splats(const std::vector<scene::Source>& sources, const SubjectOptions& options)
        : models_(sources, options.cache, {true, true}),
          kind_(options.splat),
          chosen_(fastest_painter(
              models_.placed(), backends_to_choose_from(options.backend),
              [&](scene::ModelPainter& painter) { return measure_ms(models_.placed(), painter, options); })) {
        if (models_.remote()) stream_.emplace(models_.placed(), *models_.remote(), scene::StreamOptions());
    }

    geom::Sphere bounds() const override { return scene::bounds_of(models_.placed()); }
    std::vector<geom::Sphere> outline() const override { return scene::outline_of(models_.placed()); }
    std::string describe() const override { return chosen_.description; }

    PictureReport draw(const Wish& wish, render::Frame& frame) override;
    void draw_part(const geom::View& view, const Wish& wish, render::Frame& frame) override;
    bool has_more(const Wish& wish) override;
    bool is_arriving() const override { return stream_.has_value(); }

  private:
    scene::DrawOptions options_for(const Wish& wish) const;
    std::optional<double> next_threshold() const;
    scene::DrawReport draw_in_time(const geom::View& view, const Wish& wish, scene::DrawOptions& options,
                                   render::Frame& frame);
    void begin_streaming(const geom::View& view, const Wish& wish, const scene::DrawOptions& options);
    void end_streaming(const scene::DrawReport& drawn);
    bool has_arrived();
    void lose(const core::Error& error);
    void collect_news();
    PictureReport report(const scene::DrawReport& drawn) const;

    scene::Models models_;
    render::SplatKind kind_;
    ChosenPainter chosen_;
    std::optional<scene::BudgetPainter> budget_painter_;
    double budget_ms_ = 0;
    std::optional<scene::Stream> stream_;
    std::optional<scene::StreamReport> streamed_;
    std::string trouble_;
    bool idle_is_asked_ = false;  // for what may be wanted later
    bool has_come_ = false;       // something, since the last picture
    // Of the last picture.
    std::optional<Wish> last_;
    double threshold_px_ = 0;
    splat::CutCounts counts_{};
};

scene::DrawOptions Splats::options_for(const Wish& wish) const {
    scene::DrawOptions options;
    options.cut.threshold_px = wish.threshold_px;
    options.cut.triangle_px = scene::kTrianglePx;
    options.kind = kind_;
    options.look = wish.look;
    return options;
}

std::optional<double> Splats::next_threshold() const {
    return scene::refined_threshold(threshold_px_, last_->threshold_px, counts_);
}

scene::DrawReport Splats::draw_in_time(const geom::View& view, const Wish& wish, scene::DrawOptions& options,
                                       render::Frame& frame) {
    if (!budget_painter_ || budget_ms_ != wish.budget_ms) {
        budget_ms_ = wish.budget_ms;
        budget_painter_.emplace(*chosen_.painter, budget_ms_);
    }
    return budget_painter_->draw(view, options, frame);
}

PictureReport Splats::draw(const Wish& wish, render::Frame& frame) {
    const geom::View view = geom::make_view(wish.camera, wish.width, wish.height);
    scene::DrawOptions options = options_for(wish);
    const bool is_new = !last_ || !show_the_same(*last_, wish);
    if (!is_new) options.cut.threshold_px = next_threshold().value_or(threshold_px_);
    begin_streaming(view, wish, options);
    const scene::DrawReport drawn =
        is_new ? draw_in_time(view, wish, options, frame) : chosen_.painter->draw(view, options, frame);
    last_ = wish;
    threshold_px_ = options.cut.threshold_px;
    counts_ = drawn.counts;
    end_streaming(drawn);
    return report(drawn);
}

void Splats::draw_part(const geom::View& view, const Wish& wish, render::Frame& frame) {
    chosen_.painter->draw(view, options_for(wish), frame);
}

void Splats::begin_streaming(const geom::View& view, const Wish& wish, const scene::DrawOptions& options) {
    if (!stream_) return;
    has_come_ = false;
    scene::DrawOptions asked = options;
    // What to ask for is found by drawing: while the camera moves, no finer than is drawn.
    if (wish.is_moving) asked.cut.threshold_px = std::max(options.cut.threshold_px, threshold_px_);
    std::vector<geom::View> views{view};
    // What is under the lens is asked for as it is seen there, where it owns more pixels.
    if (wish.lens) views.push_back(view_of(*wish.lens, view));
    try {
        stream_->show(std::move(views), asked,
                      wish.is_moving ? std::optional(stream_->elapsed_s()) : std::nullopt);
    } catch (const core::Error& error) {
        lose(error);
    }
}

void Splats::end_streaming(const scene::DrawReport& drawn) {
    if (!stream_) return;
    try {
        const uint64_t bytes_before = streamed_ ? streamed_->network.bytes : 0;
        streamed_ = stream_->look(*chosen_.painter, drawn);
        if (streamed_->network.bytes > bytes_before) trouble_.clear();
        idle_is_asked_ = false;
        collect_news();
    } catch (const core::Error& error) {
        lose(error);
    }
}

// What is there can be drawn still.
void Splats::lose(const core::Error& error) {
    trouble_ = error.what();
    stream_.reset();
}

void Splats::collect_news() {
    for (std::string& line : models_.remote()->news()) trouble_ = std::move(line);
}

bool Splats::has_arrived() {
    if (!stream_) return false;
    try {
        // What owns no pixel yet, and what may be seen next, is asked for once nothing else is to be done.
        if (streamed_ && streamed_->visible_blocks_missing == 0 && !idle_is_asked_) {
            stream_->ask_ahead();
            idle_is_asked_ = true;
        }
        if (models_.remote()->wait(0)) has_come_ = true, idle_is_asked_ = false;
        if (!has_come_ || counts_.groups_missing == 0) return false;
        // What is hidden is missed by nobody; now and then it is looked whether it is all hidden still.
        return !streamed_ || streamed_->visible_blocks_missing > 0 ||
               stream_->elapsed_s() - streamed_->elapsed_s > kHiddenLook_s;
    } catch (const core::Error& error) {
        lose(error);
        return true;
    }
}

bool Splats::has_more(const Wish& wish) {
    const bool has_come = has_arrived();
    return has_come || (!wish.is_moving && last_ && next_threshold().has_value());
}

PictureReport Splats::report(const scene::DrawReport& drawn) const {
    PictureReport r;
    r.threshold_px = threshold_px_;
    r.error_bound_px = drawn.counts.error_bound_px;
    r.splats = drawn.counts.splats;
    r.triangles = drawn.counts.triangles;
    r.has_leaf_triangles = r.triangles > 0;
    r.bytes_touched = drawn.bytes_touched;
    r.draw_ms = drawn.traverse_ms + drawn.draw_ms;
    r.is_final = !next_threshold();
    r.refinement = r.is_final ? 1 : refinement_share(threshold_px_, last_->threshold_px);
    r.trouble = trouble_;
    if (streamed_) {
        r.arrival = {streamed_->network.bytes, streamed_->visible_blocks_missing, streamed_->hit_rate};
        r.is_final = r.is_final && (drawn.counts.groups_missing == 0 || !stream_);
    }
    return r;
}

}  // namespace

std::unique_ptr<Subject> open_splats(const std::vector<scene::Source>& sources,
                                     const SubjectOptions& options) {
    return std::make_unique<Splats>(sources, options);
}

}  // namespace view
