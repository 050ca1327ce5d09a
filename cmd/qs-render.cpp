// qs-render: draw the frames of a camera path.  The work is scene::ModelPainter and scene::Reference.
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "geom/path.h"
#include "mesh/mesh.h"
#include "qs-render/arguments.h"
#include "qs-render/picture_files.h"
#include "qs-render/sources.h"
#include "scene/backends.h"
#include "scene/draw.h"
#include "scene/frame_report.h"
#include "scene/outputs.h"
#include "scene/reference.h"

namespace {

using core::text;
using qs_render::Arguments;
using qs_render::Models;
using qs_render::Source;

std::vector<geom::Camera> cameras_of(const Arguments& a, const Models& models) {
    if (a.path.empty())
        return {a.camera.camera(scene::bounds_of(models.placed()), a.resolution[0] / a.resolution[1])};
    const core::InputFile file(a.path);
    return geom::parse_path({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                            file.name());
}

// The rate at which the path's times pass where every `step`-th frame is drawn.
double frames_per_s(const Arguments& a, const std::vector<geom::Camera>& path, size_t step) {
    if (!std::isnan(a.fps)) return a.fps;
    const double seconds = path.back().time_s - path.front().time_s;
    const double fps = double(path.size() - 1) / (seconds * double(step));
    return fps >= 0.001 && fps <= 1000 ? fps : geom::kDefaultFps;
}

std::unique_ptr<scene::Reference> reference_of(const Arguments& a, const Models& models) {
    if (a.reference.empty()) return nullptr;
    const bool has_colour = models.has_colour();
    auto reference =
        std::make_unique<scene::Reference>(mesh::read_mesh(a.reference).mesh, a.reference, has_colour);
    if (has_colour && !reference->has_colour())
        core::warn(a.reference + ": has no colours, unlike the model; its frames are grey");
    return reference;
}

scene::Backend open_backend(const Arguments& a) {
    try {
        scene::Backend backend = scene::open_backend(qs_render::backend_of(a));
        core::notice("back end " + backend.name + ": " + backend.is +
                     (backend.reason.empty() ? "" : " (" + backend.reason + ")"));
        return backend;
    } catch (const core::Error& error) {
        throw core::Error("--backend " + a.backend + ": " + error.what() + "; --list-backends says what there is");
    }
}

std::vector<std::string> inputs_of(const Arguments& a, const std::vector<Source>& sources) {
    std::vector<std::string> inputs{a.path, a.reference};
    for (const Source& source : sources) inputs.insert(inputs.end(), {source.file, source.transform_file});
    return inputs;
}

void draw_frames(const Arguments& a, const scene::DrawOptions& draw, const Models& models,
                 const std::vector<std::string>& inputs, const std::vector<geom::Camera>& path,
                 const std::vector<int>& frames, scene::Backend backend) {
    core::Report report(inputs);
    qs_render::PictureFiles files(a.output, qs_render::format_of(a),
                                  frames_per_s(a, path, qs_render::frame_range(a).step), a.depth);
    const std::unique_ptr<scene::Reference> reference = reference_of(a, models);
    scene::ModelPainter painter(models.placed(), std::move(backend.painter));
    if (draw.occlusion == scene::Occlusion::on && !painter.can_hide())
        throw core::UsageError("--occlusion on: only the back end cpu can leave out what is hidden, not " +
                               backend.name);
    render::Frame frame;
    core::Progress progress("frame", frames.size());
    uint64_t done = 0;
    const scene::Screen screen = qs_render::screen(a);
    // The default is a wish that small models cannot meet; squares and circles have no bound to hold against
    // it; of a prefix has been warned.
    const bool warns_of_leaves =
        a.threshold->count() > 0 && models.are_complete() &&
        (draw.kind == render::SplatKind::ellipse || draw.kind == render::SplatKind::smooth);
    size_t coarse_count = 0;
    for (const int number : frames) {
        const geom::Camera& camera = path[size_t(number)];
        bool is_coarse = false;
        for (const auto& [eye, view] : scene::views_of(camera, screen)) {
            scene::FrameReport line;
            line.frame = number;
            line.eye = eye;
            line.time_s = camera.time_s;
            line.backend = backend.name;
            line.cut = draw.cut;
            line.draw = painter.draw(view, draw, frame);
            core::Stopwatch watch;
            files.write(number, eye, frame);
            line.write_ms = watch.lap_ms();
            if (reference) {
                line.reference = reference->measure(view, draw.look, frame);
                line.reference_ms = watch.lap_ms();
            }
            if (report.is_wanted()) report.write(scene::to_json(line));
            is_coarse = is_coarse || line.misses_threshold();
        }
        coarse_count += warns_of_leaves && is_coarse;
        progress.update(++done);
    }
    files.finish();
    report.commit();
    if (coarse_count > 0)
        core::warn(text("threshold %g px not met in %zu of %zu frames: the model's leaves are coarser",
                        draw.cut.threshold_px, coarse_count, frames.size()));
}

void run(const Arguments& a) {
    if (a.lists_backends) return core::print(scene::list_backends());
    const std::vector<Source> sources = qs_render::parse_sources(a.sources);
    qs_render::check(a, sources);
    const scene::DrawOptions draw = qs_render::draw_options(a);
    const Models models(sources);
    const std::vector<geom::Camera> path = cameras_of(a, models);
    const std::vector<std::string> inputs = inputs_of(a, sources);
    const std::vector<int> frames = qs_render::frame_numbers(qs_render::frame_range(a), path.size());
    scene::check({a.output, a.depth, qs_render::format_of(a), a.report}, inputs, {frames, a.is_stereo});
    for (const splat::Model& model : models.all())
        if (!model.is_complete())
            core::warn(text("%s: holds %llu of %llu blocks; what is drawn is as fine as they are",
                            model.name().c_str(), static_cast<unsigned long long>(model.blocks_present()),
                            static_cast<unsigned long long>(model.header().block_count)));
    draw_frames(a, draw, models, inputs, path, frames, open_backend(a));
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
