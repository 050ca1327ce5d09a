#include "qs-render/mesh_film.h"

#include <algorithm>
#include <memory>

#include "core/error.h"
#include "core/file.h"
#include "core/messages.h"
#include "core/report.h"
#include "core/stopwatch.h"
#include "mesh/reader.h"
#include "qs-render/picture_files.h"
#include "scene/frame_report.h"
#include "scene/outputs.h"
#include "scene/progressive.h"
#include "scene/reference.h"

namespace qs_render {

using core::text;

namespace {

void check_options(const Arguments& a) {
    const std::pair<const char*, bool> others[] = {{"--budget", a.has_budget()},
                                                   {"--refine", a.refine},
                                                   {"--explain", a.explain},
                                                   {"--threshold-diameter", a.cuts_by_diameter()},
                                                   {"--occlusion on", a.occlusion == "on"},
                                                   {"--keep-going", a.keep_going}};
    for (const auto& [option, is_given] : others)
        if (is_given) throw core::UsageError(std::string(option) + ": means nothing for a progressive mesh");
}

std::vector<geom::Camera> cameras_of(const Arguments& a, const scene::ProgressiveSource& source) {
    if (a.path.empty())
        return {a.camera.camera(source.bounds(), source.outline(), a.resolution[0] / a.resolution[1])};
    const core::InputFile file(a.path);
    return geom::parse_path({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                            file.name());
}

class MeshFilm {
  public:
    MeshFilm(const Arguments& a, scene::ProgressiveSource& source, const std::vector<std::string>& inputs)
        : a_(a),
          source_(source),
          draw_(draw_options(a)),
          backend_(scene::open_backend(backend_of(a))),
          report_(inputs, {}),
          files_(a.output, format_of(a), std::isnan(a.fps) ? geom::kDefaultFps : a.fps, a.depth) {
        if (!a.reference.empty())
            reference_ = std::make_unique<scene::Reference>(mesh::read_mesh(a.reference).mesh, a.reference,
                                                            source.has_colour());
    }

    void take(int number, const geom::Camera& camera) {
        for (const scene::EyeView& eye : scene::views_of(camera, screen(a_))) draw(number, camera, eye);
    }
    void finish() {
        files_.finish();
        report_.commit();
    }

  private:
    void draw(int number, const geom::Camera& camera, const scene::EyeView& eye) {
        scene::FrameReport line;
        line.frame = number;
        line.eye = eye.eye;
        line.time_s = camera.time_s;
        line.backend = backend_.name;
        line.cut = draw_.cut;
        core::Stopwatch watch;
        scene::ProgressiveCosts costs;
        const mesh::Mesh mesh = source_.mesh_for(camera, int(a_.resolution[0]), int(a_.resolution[1]),
                                                 draw_.cut.threshold_px, costs);
        line.draw.traverse_ms = watch.lap_ms();
        scene::draw_mesh(mesh, eye.view, draw_.look, *backend_.painter, frame_);
        line.draw.draw_ms = watch.lap_ms();
        splat::CutCounts& counts = line.draw.counts;
        counts.nodes_visited = costs.nodes_tested;
        counts.frustum_culled = costs.outside, counts.backface_culled = costs.faces_away;
        counts.triangles = mesh.triangles.size();
        // The error of a split is measured, not proven (pm(5)).
        counts.error_bound_px = std::numeric_limits<double>::infinity();
        if (reference_) {
            line.reference = reference_->measure(eye.view, draw_.look, frame_);
            line.reference_ms = watch.lap_ms();
        }
        files_.write(number, eye.eye, frame_);
        line.write_ms = watch.lap_ms();
        core::Json json = scene::to_json(line);
        json["splits"] = costs.splits;
        json["bytes_up"] = costs.bytes_up;
        json["bytes_down"] = costs.bytes_down;
        report_.write(json);
    }

    const Arguments& a_;
    scene::ProgressiveSource& source_;
    const scene::DrawOptions draw_;
    scene::Backend backend_;
    core::Report report_;
    PictureFiles files_;
    std::unique_ptr<scene::Reference> reference_;
    render::Frame frame_;
};

}  // namespace

bool are_progressive(const std::vector<Source>& sources) {
    const bool is_one = std::any_of(sources.begin(), sources.end(),
                                    [](const Source& source) { return scene::is_progressive(source.file); });
    if (is_one && (sources.size() > 1 || sources[0].is_placed))
        throw core::UsageError("SOURCE: a progressive mesh is drawn alone and without a transform");
    return is_one;
}

void draw_progressive(const Arguments& a, const std::string& source_name) {
    check_options(a);
    const auto source = scene::open_progressive(source_name);
    const std::vector<geom::Camera> cameras = cameras_of(a, *source);
    const std::vector<int> frames = frame_numbers(frame_range(a), cameras.size());
    const std::vector<std::string> inputs{a.path, a.reference, source_name};
    scene::check({a.output, a.depth, format_of(a), a.report}, inputs, {frames, a.is_stereo});
    MeshFilm film(a, *source, inputs);
    core::Progress progress("frame", frames.size());
    uint64_t done = 0;
    for (const int number : frames) {
        film.take(number, cameras[size_t(number)]);
        progress.update(++done);
    }
    film.finish();
}

}  // namespace qs_render
