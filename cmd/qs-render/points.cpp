#include "qs-render/points.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>

#include "core/error.h"
#include "core/file.h"
#include "core/messages.h"
#include "core/report.h"
#include "core/stopwatch.h"
#include "mesh/mesh.h"
#include "ppve/client/reconstruction.h"
#include "ppve/link.h"
#include "qs-render/arguments.h"
#include "qs-render/picture_files.h"
#include "scene/frame_report.h"
#include "scene/outputs.h"
#include "scene/reference.h"
#include "scene/shots.h"

namespace qs_render {

using core::text;
using core::UsageError;

namespace {

using Clock = std::chrono::steady_clock;

void check_points(const Arguments& a) {
    if (a.sources.size() > 1 || (a.sources.size() == 1 && !a.ppve_command.empty()))
        throw UsageError("SOURCE: a server's points are drawn alone");
    const std::pair<const char*, bool> useless[] = {{"--threshold", a.threshold_is_given()},
                                                    {"--threshold-diameter", a.cuts_by_diameter()},
                                                    {"--budget", a.has_budget()},
                                                    {"--refine", a.refine},
                                                    {"--explain", a.explain},
                                                    {"--tile", !a.tile.empty()},
                                                    {"--samples", a.samples != "1"},
                                                    {"--keep-going", a.keep_going}};
    for (const auto& [option, is_given] : useless)
        if (is_given) throw UsageError(std::string(option) + ": not for a server's points");
    if (a.output.empty() && a.depth.empty() && a.report.empty())
        throw UsageError("nothing to write; give -o, --depth or --report");
    if (!a.reference.empty() && a.report.empty())
        throw UsageError("--reference: its measures go to --report, which is not given");
    if (!a.frames.empty() && a.path.empty()) throw UsageError("--frames: needs --path");
    const std::string camera = a.camera.given();
    if (!a.path.empty() && !camera.empty())
        throw UsageError(camera + ": not with --path, which has the cameras");
}

ppve::Client::OpenLink link_of(const Arguments& a, const PointSettings& settings, ppve::Recorder* recorder) {
    const auto open = [source = a.sources.empty() ? std::string() : a.sources[0], command = a.ppve_command,
                       timeout_s = settings.client.answer_timeout_s]() -> std::unique_ptr<ppve::Link> {
        if (!command.empty()) return ppve::start_command(command);
        return ppve::is_session_file(source) ? ppve::replay(source)
                                             : ppve::connect_to_server(source, timeout_s);
    };
    return [open, recorder] { return recorder ? ppve::recorded(open(), *recorder) : open(); };
}

std::vector<geom::Camera> cameras_of(const Arguments& a, ppve::Client& client) {
    if (!a.path.empty()) {
        const core::InputFile file(a.path);
        return geom::parse_path({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                                file.name());
    }
    const ppve::Box box = client.wait_for_bounds();
    return {a.camera.camera(box.sphere(), box.corners(), a.resolution[0] / a.resolution[1])};
}

double frames_per_s(const Arguments& a, const std::vector<geom::Camera>& path) {
    if (!std::isnan(a.fps)) return a.fps;
    const double fps = double(path.size() - 1) / (path.back().time_s - path.front().time_s);
    return fps >= 0.001 && fps <= 1000 ? fps : geom::kDefaultFps;
}

// What a frame cost, and what the client has; the keys are in qs-render(1).
core::Json line_of(const ppve::ReconstructionCounts& drawn, const ppve::ClientCounts& client) {
    core::Json json;
    json["clusters"] = drawn.clusters;
    json["clusters_seen"] = drawn.clusters_seen;
    json["patches"] = drawn.patches_drawn;
    json["patches_facing_away"] = drawn.patches_facing_away;
    json["patches_coarser_for_budget"] = drawn.coarser_for_budget;
    json["points"] = drawn.points_chosen;
    json["points_drawn"] = drawn.points_drawn;
    json["updates"] = client.updates;
    json["updates_at_rest"] = client.updates_at_rest;
    json["bytes_received"] = client.bytes_received;
    json["samples"] = client.samples;
    json["samples_kept"] = client.samples_kept;
    json["points_removed"] = client.points_removed;
    json["clusters_deleted"] = client.clusters_deleted;
    json["cache_points"] = client.points;
    json["cache_bytes"] = client.bytes;
    json["cache_bytes_most"] = client.most_bytes;
    json["latency_ms"] = 1000 * client.latency_s;
    json["server_ms"] = client.server_ms;
    json["take_in_ms"] = client.take_in_ms;
    json["out_of_step"] = client.out_of_step;
    json["connections"] = client.connections;
    return json;
}

// The frames of a path, one after the other.
class PointFilm {
  public:
    PointFilm(const Arguments& a, const PointSettings& settings, ppve::Client& client, double fps);
    void take(int number, const geom::Camera& camera);
    void finish();

  private:
    bool wait(const ppve::Gaze& gaze);
    ppve::ReconstructionOptions options_for(bool is_complete);
    void write(int number, const geom::Camera& camera, const std::vector<scene::EyeView>& views,
               double scale);

    const Arguments& a_;
    const PointSettings& settings_;
    const render::Look look_;
    const scene::Screen screen_;
    ppve::Client& client_;
    core::Report report_;
    PictureFiles files_;
    std::unique_ptr<scene::Reference> reference_;
    ppve::Reconstruction reconstruction_;
    std::array<render::Frame, 2> frames_;
    std::vector<ppve::ReconstructionCounts> counts_;
    std::optional<geom::View> last_view_;
    std::optional<Clock::time_point> start_;  // of the path's times
    double first_s_ = 0;
};

render::Look look_of(const Arguments& a, const PointSettings& settings) {
    render::Look look = draw_options(a).look;
    if (settings.is_lit_by_server) look.shade = render::Shade::flat;
    return look;
}

PointFilm::PointFilm(const Arguments& a, const PointSettings& settings, ppve::Client& client, double fps)
    : a_(a),
      settings_(settings),
      look_(look_of(a, settings)),
      screen_(screen(a)),
      client_(client),
      report_({a.path, a.reference}, {}),
      files_(a.output, format_of(a), fps, a.depth) {
    if (!a.reference.empty())
        reference_ = std::make_unique<scene::Reference>(mesh::read_mesh(a.reference).mesh, a.reference, true);
}

// Until there is what is to be drawn; true where it is complete.
bool PointFilm::wait(const ppve::Gaze& gaze) {
    if (!settings_.is_realtime || !start_) {
        client_.wait_until_settled();
        start_ = Clock::now();
    }
    return client_.is_settled() && gaze.is_still;
}

// How far the picture moves in a frame: by the eye's turning, and by its moving at the target's distance.
double moved_px(const geom::View& before, const geom::View& now, double distance) {
    const double turned = std::acos(std::clamp(glm::dot(before.forward, now.forward), -1.0, 1.0));
    return now.focal_px * (turned + glm::length(now.eye - before.eye) / distance);
}

ppve::ReconstructionOptions PointFilm::options_for(bool is_complete) {
    ppve::ReconstructionOptions options = is_complete ? ppve::ReconstructionOptions::of_complete_picture()
                                                      : ppve::ReconstructionOptions::of_moving_eye();
    options.scale = settings_.scale;
    if (settings_.rule) options.ratio = settings_.rule->ratio, options.epsilon = settings_.rule->epsilon;
    options.most_points = settings_.most_points;
    options.is_closed = settings_.is_closed;
    options.look = look_;
    return options;
}

void PointFilm::take(int number, const geom::Camera& camera) {
    const std::vector<scene::EyeView> views = scene::views_of(camera, screen_);
    ppve::Gaze gaze;
    gaze.camera = camera;
    for (const scene::EyeView& eye : views) gaze.eyes.push_back(eye.view);
    gaze.is_still = !settings_.is_realtime || !start_;
    if (!start_) first_s_ = camera.time_s;
    if (settings_.is_realtime && start_) {
        std::this_thread::sleep_until(*start_ + std::chrono::duration_cast<Clock::duration>(
                                                    std::chrono::duration<double>(camera.time_s - first_s_)));
        gaze.time_s = std::chrono::duration<double>(Clock::now() - *start_).count();
    } else {
        gaze.time_s = settings_.is_realtime ? 0 : camera.time_s;
    }
    client_.look(gaze);
    const bool is_complete = wait(gaze);
    ppve::ReconstructionOptions options = options_for(is_complete);
    if (settings_.velocity_px > 0 && last_view_)
        options.velocity =
            std::max(1.0, moved_px(*last_view_, views[0].view, glm::length(camera.target - camera.eye)) /
                              settings_.velocity_px);
    last_view_ = views[0].view;
    std::vector<uint8_t> seen;
    const auto model = client_.model();
    counts_ = reconstruction_.draw(*model, gaze.eyes, options, std::span(frames_).first(views.size()), &seen);
    client_.note_drawn(*model, seen);
    write(number, camera, views, options.scale);
}

void PointFilm::write(int number, const geom::Camera& camera, const std::vector<scene::EyeView>& views,
                      double scale) {
    const ppve::ClientCounts client = client_.counts();
    for (size_t k = 0; k < views.size(); ++k) {
        core::Stopwatch watch;
        files_.write(number, views[k].eye, frames_[k]);
        const double write_ms = watch.lap_ms();
        if (!report_.is_wanted()) continue;
        core::Json line;
        line["frame"] = number;
        if (!views[k].eye.empty()) line["eye"] = views[k].eye;
        line["t"] = camera.time_s;
        line["backend"] = "points";
        // Both eyes are drawn at once.
        line["ms"] = {{"select", counts_[k].select_ms},
                      {"draw", counts_[k].draw_ms},
                      {"write", write_ms},
                      {"total", counts_[k].select_ms + counts_[k].draw_ms + write_ms}};
        line["scale"] = scale;
        line.update(line_of(counts_[k], client));
        if (reference_) scene::add_reference(line, reference_->measure(views[k].view, look_, frames_[k]));
        report_.write(line);
    }
}

void PointFilm::finish() {
    files_.finish();
    report_.commit();
}

}  // namespace

bool draws_points(const Arguments& a) {
    if (!a.ppve_command.empty()) return true;
    return std::any_of(a.sources.begin(), a.sources.end(), [](const std::string& word) {
        return ppve::is_server_address(word) || ppve::is_session_file(word);
    });
}

void draw_points(const Arguments& a) {
    PointSettings settings = parse_point_settings(a.ppve);
    check_points(a);
    settings.client.wants_normals = !settings.is_lit_by_server;
    std::optional<ppve::Recorder> recorder;
    if (!settings.record.empty()) recorder.emplace(settings.record);
    {
        ppve::Client client(link_of(a, settings, recorder ? &*recorder : nullptr), settings.client);
        const std::vector<geom::Camera> path = cameras_of(a, client);
        const std::vector<int> numbers = frame_numbers(frame_range(a), path.size());
        scene::check({a.output, a.depth, format_of(a), a.report},
                     std::vector<std::string>{a.path, a.reference}, {numbers, a.is_stereo});
        PointFilm film(a, settings, client, frames_per_s(a, path));
        core::Progress progress("frame", numbers.size());
        uint64_t done = 0;
        for (const int number : numbers) {
            film.take(number, path[size_t(number)]);
            progress.update(++done);
        }
        film.finish();
        const ppve::ClientCounts counts = client.counts();
        if (counts.failures > 0)
            core::warn(text("the server was lost %llu times: %s",
                            static_cast<unsigned long long>(counts.failures), counts.failure.c_str()));
    }
    if (recorder) recorder->commit();
}

}  // namespace qs_render
