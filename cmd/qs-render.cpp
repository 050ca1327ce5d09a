// qs-render: draw the frames of a camera path.  The work is that of scene::ModelPainter and scene::Reference.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/messages.h"
#include "core/program.h"
#include "geom/path.h"
#include "qs-render/arguments.h"
#include "qs-render/film.h"
#include "qs-render/mesh_film.h"
#include "qs-render/points.h"
#include "scene/backends.h"
#include "scene/draw.h"
#include "scene/explain.h"
#include "scene/outputs.h"
#include "scene/plan.h"
#include "scene/sources.h"

namespace {

using core::text;
using qs_render::Arguments;
using scene::Models;
using scene::Source;

using Path = std::vector<geom::PathFrame>;

// Lines that are wrong are among them with --keep-going only.
Path cameras_of(const Arguments& a, const Models& models) {
    if (a.path.empty()) {
        const geom::Camera camera = a.camera.camera(
            scene::bounds_of(models.placed()),
            a.camera.needs_outline() ? scene::outline_of(models.placed()) : std::vector<geom::Sphere>(),
            a.resolution[0] / a.resolution[1]);
        std::string line = geom::format_camera(camera);
        line.pop_back();  // its newline
        core::notice("camera: " + line);
        const size_t count = std::max<size_t>(1, qs_render::snapshot_times_s(a.streaming.snapshot).size());
        return Path(count, {camera, ""});
    }
    const core::InputFile file(a.path);
    Path path = geom::parse_frames({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                                   file.name());
    for (const geom::PathFrame& frame : path)
        if (!frame.fault.empty() && !a.keep_going) throw core::Error(frame.fault);
    return path;
}

// The rate at which the path's times pass where every `step`-th frame is drawn.
double frames_per_s(const Arguments& a, const Path& path, size_t step) {
    if (!std::isnan(a.fps)) return a.fps;
    const auto is_right = [](const geom::PathFrame& frame) { return frame.fault.empty(); };
    const auto first = std::find_if(path.begin(), path.end(), is_right);
    const auto last = std::find_if(path.rbegin(), path.rend(), is_right);
    if (first == path.end()) return geom::kDefaultFps;
    const double seconds = last->camera.time_s - first->camera.time_s;
    const double fps = double(&*last - &*first) / (seconds * double(step));
    return fps >= 0.001 && fps <= 1000 ? fps : geom::kDefaultFps;
}

scene::Backend open_backend(const Arguments& a) {
    try {
        scene::Backend backend = scene::open_backend(qs_render::backend_of(a));
        core::notice("back end " + backend.name + ": " + backend.is +
                     (backend.reason.empty() ? "" : " (" + backend.reason + ")"));
        return backend;
    } catch (const core::Error& error) {
        throw core::Error("--backend " + a.backend + ": " + error.what() +
                          "; --list-backends says what there is");
    }
}

std::vector<std::string> inputs_of(const Arguments& a, const std::vector<Source>& sources) {
    std::vector<std::string> inputs{a.path, a.reference};
    for (const Source& source : sources) inputs.insert(inputs.end(), {source.file, source.transform_file});
    return inputs;
}

void tell_news(const Models& models) {
    for (const std::string& line : models.remote()->news()) core::warn(line);
}

using Clock = std::chrono::steady_clock;

void draw_frames(const Arguments& a, const scene::DrawOptions& draw, const Models& models,
                 const std::vector<std::string>& inputs, const Path& path, const std::vector<int>& frames,
                 Clock::time_point start) {
    qs_render::Film film(a, draw, models, inputs, frames_per_s(a, path, qs_render::frame_range(a).step),
                         open_backend(a));
    std::optional<scene::Stream> stream;
    if (models.remote()) {
        scene::StreamOptions options = qs_render::stream_options(a.streaming);
        options.start = start;
        film.follow(stream.emplace(models.placed(), *models.remote(), options));
    }
    const qs_render::Schedule schedule(a.streaming, stream ? stream->elapsed_s() : 0);
    core::Progress progress("frame", frames.size());
    uint64_t done = 0;
    for (const int number : frames) {
        if (const std::optional<double> due_s = schedule.due_s(done)) {
            if (done == 0) film.expect(path[size_t(number)]);
            stream->wait_until(*due_s);
        }
        film.take(number, path[size_t(number)]);
        if (stream) tell_news(models);
        progress.update(++done);
    }
    film.finish();
}

// The first of them; with --keep-going, the first that can be drawn.
const geom::PathFrame& shot_to_explain(const Arguments& a, const Path& path, const std::vector<int>& frames) {
    for (const int number : frames) {
        const geom::PathFrame& shot = path[size_t(number)];
        if (shot.fault.empty()) return shot;
        core::fail(text("frame %d: ", number) + shot.fault);
    }
    throw core::Error(std::string(a.explain ? "--explain" : "--plan") + ": none of the frames can be drawn");
}

// Of one eye.
void explain(const Arguments& a, const scene::DrawOptions& draw, const Models& models,
             const geom::PathFrame& shot, scene::Backend backend) {
    scene::ModelPainter painter(models.placed(), std::move(backend.painter));
    qs_render::check_occlusion(draw, painter, backend.name);
    const geom::View view = scene::views_of(shot.camera, qs_render::screen(a)).front().view;
    scene::Explanation explanation = scene::explain(painter, view, draw);
    explanation.frame.backend = backend.name;
    explanation.parts.insert(explanation.parts.begin(), scene::part_of(backend));
    core::print(a.json ? scene::to_json(explanation).dump() + "\n" : scene::to_text(explanation));
}

void plan(const Arguments& a, const scene::DrawOptions& draw, const Models& models,
          const geom::PathFrame& shot) {
    scene::ModelPainter painter(models.placed());
    scene::LackFinder finder(models.placed());
    const geom::View view = scene::views_of(shot.camera, qs_render::screen(a)).front().view;
    scene::StreamOptions sample = qs_render::stream_options(a.streaming);
    sample.prefetches = false;
    sample.byte_budget = scene::kPlanBytes * models.all().size();
    scene::Stream stream(models.placed(), *models.remote(), sample);
    stream.show({view}, draw);
    stream.settle(painter);
    render::Frame frame;
    painter.draw(view, draw, frame);
    const scene::Plan plan = scene::plan_of(models.placed(), finder.find(view, draw, std::nullopt), draw.cut);
    core::print(a.json ? scene::to_json(plan).dump() + "\n" : scene::to_text(plan));
}

void run(const Arguments& a) {
    if (a.lists_backends) return core::print(scene::list_backends());
    if (qs_render::draws_points(a)) return qs_render::draw_points(a);
    if (a.sources.empty()) throw core::UsageError("SOURCE is required");
    const std::vector<Source> sources = scene::parse_sources(a.sources);
    qs_render::check(a, sources);
    if (qs_render::are_progressive(sources)) return qs_render::draw_progressive(a, sources[0].file);
    const scene::DrawOptions draw = qs_render::draw_options(a);
    const Clock::time_point start = Clock::now();
    const Models models(sources, a.streaming.cache,
                        {!a.streaming.draws_at_once(), a.path.empty() && a.camera.needs_outline()});
    const Path path = cameras_of(a, models);
    const std::vector<std::string> inputs = inputs_of(a, sources);
    const std::vector<int> frames = qs_render::frame_numbers(qs_render::frame_range(a), path.size());
    scene::check({a.output, a.depth, qs_render::format_of(a), a.report}, inputs, {frames, a.is_stereo});
    for (const splat::Model& model : models.all())
        if (!model.is_complete() && !model.is_arriving())
            core::warn(text("%s: holds %llu of %llu blocks; what is drawn is as fine as they are",
                            model.name().c_str(), static_cast<unsigned long long>(model.blocks_present()),
                            static_cast<unsigned long long>(model.header().block_count)));
    if (a.streaming.plan)
        plan(a, draw, models, shot_to_explain(a, path, frames));
    else if (a.explain)
        explain(a, draw, models, shot_to_explain(a, path, frames), open_backend(a));
    else
        draw_frames(a, draw, models, inputs, path, frames, start);
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("qs-render", "Draw the frames of a camera path from a splat model.", QS_VERSION);
    Arguments arguments;
    qs_render::add_options(program, arguments);
    return program.run(argc, argv, [&] {
        arguments.report = program.options.get_option("--report")->as<std::string>();
        run(arguments);
    });
}
