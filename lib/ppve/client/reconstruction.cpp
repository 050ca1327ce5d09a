#include "ppve/client/reconstruction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.h"
#include "core/parallel.h"
#include "core/stopwatch.h"
#include "ppve/client/gaps.h"
#include "ppve/elimination.h"
#include "render/shading.h"

namespace ppve {

namespace {

// A patch as it is to be drawn.
struct Choice {
    const PatchLevels* patch;
    size_t level;
    size_t cluster;       // number in the model
    float splat_px;       // of the level, before the scale
    double distance;      // of its cluster, tree units
    float reduction = 1;  // by the revised rule
    PointView::Rows rows{};
};

// With `target` pixels a splat is as fine as is desired; a level more doubles it.
size_t nearest_level(float splat_px, double target, size_t levels) {
    if (!(splat_px < 1e30f)) return 0;
    const double level = std::round(std::log2(target / double(splat_px)));
    return static_cast<size_t>(std::clamp(level, 0.0, double(levels - 1)));
}

float size_at(float splat_px, size_t level) {
    return splat_px * static_cast<float>(1 << level);
}

// Of one cluster's patches.
void apply_rule(const ReconstructionOptions& options, std::span<Choice> choices) {
    if (options.ratio <= 0 || choices.size() < 2) return;
    const auto misfit = [&](const Choice& c) {
        return std::fabs(std::log(double(c.splat_px) / options.velocity));
    };
    const float best =
        std::min_element(choices.begin(), choices.end(), [&](const Choice& a, const Choice& b) {
            return misfit(a) < misfit(b);
        })->splat_px;
    for (Choice& c : choices)
        if (double(c.splat_px) > options.ratio * double(best) && std::isfinite(c.splat_px))
            c.reduction = (best + static_cast<float>(options.epsilon) * c.splat_px) / c.splat_px;
}

uint64_t points_of(std::span<const Choice> choices) {
    uint64_t sum = 0;
    for (const Choice& c : choices) sum += c.patch->points(c.level).size();
    return sum;
}

// The farthest first, by a level, again and again.
uint64_t keep_budget(uint64_t most_points, std::vector<Choice>& choices) {
    uint64_t points = points_of(choices), coarser = 0;
    if (points <= most_points) return 0;
    std::vector<Choice*> by_distance;
    for (Choice& c : choices) by_distance.push_back(&c);
    std::stable_sort(by_distance.begin(), by_distance.end(),
                     [](const Choice* a, const Choice* b) { return a->distance > b->distance; });
    for (size_t round = 0; round < kMostCoarser; ++round)
        for (Choice* c : by_distance) {
            if (points <= most_points) return coarser;
            if (c->level + 1 >= c->patch->levels()) continue;
            points -= c->patch->points(c->level).size() - c->patch->points(c->level + 1).size();
            ++c->level, ++coarser;
            c->splat_px *= 2;
        }
    return coarser;
}

// Normals of all codes, once.
const std::vector<glm::vec3>& normals_of_codes() {
    static const std::vector<glm::vec3> normals = [] {
        std::vector<glm::vec3> all(65536);
        for (uint32_t code = 0; code < 65536; ++code)
            all[code] = octahedral_normal(static_cast<uint16_t>(code));
        return all;
    }();
    return normals;
}

PointShading shading_of(const render::Look& look, const geom::View& view) {
    PointShading shading;
    if (look.shade != render::Shade::lit && look.shade != render::Shade::normal) return shading;
    const render::Light light = render::light_of(look, view);
    const glm::mat3 view_from_world = glm::transpose(glm::mat3(view.right, view.down, view.forward));
    const bool is_lit = look.shade == render::Shade::lit;
    (is_lit ? shading.factor : shading.colour).resize(65536);
    for (uint32_t code = 0; code < 65536; ++code) {
        const glm::vec3 normal = view_from_world * normals_of_codes()[code];
        if (is_lit) {
            const float factor = code == kUnknownNormal ? 1 : render::factor_of(light, normal);
            shading.factor[code] = static_cast<uint32_t>(std::clamp(factor, 0.0f, 1.0f) * 65536);
        } else {
            const glm::u8vec3 c = render::shade_point(render::Shade::normal, normal, glm::vec3(0));
            shading.colour[code] = uint32_t(c.x) | uint32_t(c.y) << 8 | uint32_t(c.z) << 16;
        }
    }
    return shading;
}

// What an eye sees, and how.
struct Eye {
    PointView view;
    PointShading shading;
    double focal_px;
    std::vector<Choice> choices;
    PointRaster* raster = nullptr;
    ReconstructionCounts counts{};
};

Eye eye_of(const PointModel& model, const geom::View& view, const ReconstructionOptions& options,
           std::vector<uint8_t>* seen) {
    core::Stopwatch watch;
    Frustum frustum;
    frustum.view = view;
    Eye eye{PointView(frustum, model.unit), shading_of(options.look, view), view.focal_px, {}, nullptr, {}};
    eye.counts.clusters = model.clusters.size();
    for (size_t number = 0; number < model.clusters.size(); ++number) {
        const size_t first = eye.choices.size();
        for (const auto& patch : model.clusters[number]->patches) {
            if (!eye.view.may_see(*patch->patch)) continue;
            if (options.is_closed && faces_away(*patch, view.eye, model.unit)) {
                ++eye.counts.patches_facing_away;
                continue;
            }
            const float finest = eye.view.splat_px(*patch->patch);
            const size_t level = nearest_level(finest, options.velocity, patch->levels());
            const double distance = glm::length((patch->patch->anchor() - view.eye) / model.unit);
            eye.choices.push_back({patch.get(), level, number, size_at(finest, level), distance});
        }
        if (eye.choices.size() == first) continue;
        ++eye.counts.clusters_seen;
        if (seen) (*seen)[number] = 1;
        apply_rule(options, std::span(eye.choices).subspan(first));
    }
    eye.counts.coarser_for_budget = keep_budget(options.most_points, eye.choices);
    eye.counts.points_chosen = points_of(eye.choices);
    eye.counts.patches_drawn = eye.choices.size();
    // From front to back: of what is hidden hardly a word is written.
    std::stable_sort(eye.choices.begin(), eye.choices.end(),
                     [](const Choice& a, const Choice& b) { return a.distance < b.distance; });
    for (Choice& c : eye.choices) c.rows = eye.view.rows_of(*c.patch->patch);
    eye.counts.select_ms = watch.lap_ms();
    return eye;
}

void resolve(const Eye& eye, const ReconstructionOptions& options, int first, int end, render::Frame& frame) {
    const render::Look& look = options.look;
    const uint32_t background =
        look.background.x | uint32_t(look.background.y) << 8 | uint32_t(look.background.z) << 16;
    const size_t width = size_t(frame.width);
    std::optional<GapCloser> gaps;
    if (options.closes_gaps) gaps.emplace(*eye.raster, eye.focal_px);
    for (int y = first; y < end; ++y) {
        const uint64_t* const words = gaps ? gaps->row(y) : eye.raster->row(y);
        const size_t row = size_t(y) * width;
        uint8_t* rgb = frame.rgb.data() + 3 * row;
        for (size_t x = 0; x < width; ++x, rgb += 3) {
            const uint32_t colour =
                words[x] == PointRaster::kEmpty ? background : static_cast<uint32_t>(words[x]);
            rgb[0] = uint8_t(colour), rgb[1] = uint8_t(colour >> 8), rgb[2] = uint8_t(colour >> 16);
        }
        // An empty word's depth is infinity.
        for (size_t x = 0; x < width; ++x)
            frame.depth[row + x] = static_cast<float>(eye.view.depth_of(words[x]));
        for (size_t x = 0; x < width && !frame.alpha.empty(); ++x)
            frame.alpha[row + x] = words[x] == PointRaster::kEmpty ? look.background_alpha : 255;
    }
}

size_t draw_band(const Eye& eye, const ReconstructionOptions& options, int first, int end) {
    size_t drawn = 0;
    eye.raster->clear(first, end);
    for (const Choice& c : eye.choices) {
        if (c.rows.first >= end || c.rows.end <= first) continue;
        PatchStyle style;
        style.scale = static_cast<float>(options.scale * options.velocity) * c.reduction;
        const bool shows_level = options.look.shade == render::Shade::level;
        style.colour = shows_level ? render::level_colour(c.splat_px) : glm::u8vec3(0);
        style.is_coloured = shows_level;
        drawn += eye.raster->draw(eye.view, *c.patch->patch, c.patch->points(c.level),
                                  static_cast<float>(1 << c.level), style, eye.shading, first, end);
    }
    return drawn;
}

}  // namespace

ReconstructionOptions ReconstructionOptions::of_complete_picture() {
    ReconstructionOptions options;
    // The server takes points of up to rho = 1.4 footprints for as fine as its samples.
    options.ratio = EliminationRule{}.rho;
    return options;
}

ReconstructionOptions ReconstructionOptions::of_moving_eye() {
    ReconstructionOptions options;
    options.closes_gaps = true;
    return options;
}

// Threads of its own: those that take in an update at the same time must not be waited for.
struct Reconstruction::State {
    tbb::task_arena arena{core::thread_count()};
    std::vector<PointRaster> rasters;

    template <class Body>
    void for_each(size_t count, const Body& body) {
#ifdef __SANITIZE_THREAD__
        core::parallel_for(count, body);
#else
        arena.execute([&] { tbb::parallel_for(size_t(0), count, body); });
#endif
    }
};

Reconstruction::Reconstruction() : state_(std::make_unique<State>()) {}
Reconstruction::~Reconstruction() = default;

std::vector<ReconstructionCounts> Reconstruction::draw(const PointModel& model,
                                                       std::span<const geom::View> views,
                                                       const ReconstructionOptions& options,
                                                       std::span<render::Frame> frames,
                                                       std::vector<uint8_t>* seen) {
    if (options.look.samples_across != 1)
        throw core::UsageError("--samples: points are drawn with one sample a pixel");
    core::Stopwatch watch;
    if (seen) seen->assign(model.clusters.size(), 0);
    state_->rasters.resize(views.size());
    std::vector<Eye> eyes;
    for (size_t k = 0; k < views.size(); ++k) {
        eyes.push_back(eye_of(model, views[k], options, seen));
        state_->rasters[k].resize(views[k].width, views[k].height);
        eyes[k].raster = &state_->rasters[k];
        frames[k].width = views[k].width, frames[k].height = views[k].height;
        const size_t pixels = size_t(views[k].width) * size_t(views[k].height);
        frames[k].rgb.resize(3 * pixels);
        frames[k].depth.resize(pixels);
        frames[k].alpha.resize(options.look.has_alpha() ? pixels : 0);
    }
    const double select_ms = watch.lap_ms();
    // An eye a thread needs no merging; more threads have bands of it.
    const size_t bands = (size_t(core::thread_count()) + views.size() - 1) / views.size();
    std::vector<uint64_t> drawn(views.size() * bands);
    const auto for_each_band = [&](const auto& body) {
        state_->for_each(drawn.size(), [&](size_t task) {
            const size_t k = task / bands, band = task % bands, height = size_t(views[k].height);
            body(task, k, static_cast<int>(height * band / bands),
                 static_cast<int>(height * (band + 1) / bands));
        });
    };
    for_each_band([&](size_t task, size_t k, int first, int end) {
        drawn[task] = draw_band(eyes[k], options, first, end);
    });
    // Once all rows are there: a gap may be between two bands.
    for_each_band(
        [&](size_t, size_t k, int first, int end) { resolve(eyes[k], options, first, end, frames[k]); });
    std::vector<ReconstructionCounts> counts;
    const double draw_ms = watch.lap_ms();
    for (size_t k = 0; k < views.size(); ++k) {
        for (size_t band = 0; band < bands; ++band) eyes[k].counts.points_drawn += drawn[k * bands + band];
        eyes[k].counts.select_ms = select_ms;
        eyes[k].counts.draw_ms = draw_ms;
        counts.push_back(eyes[k].counts);
    }
    return counts;
}

}  // namespace ppve
