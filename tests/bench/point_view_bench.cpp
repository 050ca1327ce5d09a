// point_view_bench MESH --path FILE ...: the client of remote point sampling against a server in the same
// process, on a clock of its own, so that what is measured does not depend on the machine.  One JSON line.
//
//   --what traffic   an update at each camera of the path: bytes against whole frames, what elimination
//   leaves
//   --what motion    frames along the path while updates arrive at --rate: PSNR and holes against the mesh
//   --what draw      the time of drawing, stereo, while updates arrive: a third of the path's cameras are
//   updates at
//                    the client's resolution that are there before, the others arrive at --rate
//   --what session   --updates of small images on the path, again and again: what server and client keep
//   --what splatter  the same points as squares of lib/render's splatter
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>
#include <nanoflann.hpp>
#include <numbers>
#include <thread>

#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "geom/camera.h"
#include "geom/path.h"
#include "mesh/mesh.h"
#include "ppve/client/eye_track.h"
#include "ppve/client/point_cache.h"
#include "ppve/elimination.h"
#include "ppve/sample/raster_sampler.h"
#include "ppve/session.h"
#include "render/compare.h"
#include "render/raster.h"
#include "render/splatter.h"

namespace {

using core::Json;

struct Options {
    std::string mesh, path, what = "traffic", eliminate = "filtered";
    double rate = 4, seconds = 7, frame_s = 0.31, scale = 1, velocity = 1, ratio = 0;
    std::array<double, 2> screen{1280, 800}, size{640, 400};
    bool no_prediction = false, leaves_gaps = false, with_normals = false;
    double bound_px = 0.01, points = 4e6;
    int64_t runs = 10, updates = 10'000;
};

ppve::Elimination elimination_of(const std::string& word) {
    return word == "none"    ? ppve::Elimination::none
           : word == "paper" ? ppve::Elimination::paper
                             : ppve::Elimination::filtered;
}

// The server, and the client's cache; an update goes from one to the other at once.
class Updates {
  public:
    Updates(ppve::Sampler& sampler, const Options& options)
        : sampler_(sampler), options_(options), tree_(shape_around(sampler.bounds())), cache(tree_.shape()) {
        const ppve::Box box = sampler.bounds();
        rule_.kind = elimination_of(options.eliminate);
        rule_.epsilon = 1e-3 * 0.5 * glm::length(box.high - box.low);
    }

    void update(const ppve::Frustum& frustum) { take_in(answer_to(frustum)); }

    // The server's part.
    ppve::Answer answer_to(const ppve::Frustum& frustum) {
        ppve::DepthImage image;
        image.frustum = frustum;
        prepare(sampler_, options_.bound_px, image);
        core::Stopwatch watch;
        sampler_.sample(image, options_.with_normals);
        sample_ms += watch.lap_ms();
        const size_t whole = ppve::encode(image, ppve::Codec::planes).size();
        watch.lap_ms();
        const ppve::Eliminated eliminated = eliminate(tree_, rule_, image);
        eliminate_ms += watch.lap_ms();
        ppve::Answer answer;
        answer.id = ++updates;
        answer.replaced = ppve::write_removals(eliminated.removed);
        answer.frustum = image.frustum;
        answer.coding = image.coding;
        answer.footprint_px = image.footprint_px;
        answer.has_normals = !image.normal.empty();
        answer.image = ppve::encode(image, ppve::Codec::planes);
        encode_ms += watch.lap_ms();
        tree_.apply({false, {}, eliminated.removed, answer.id, &image});
        insert_ms += watch.lap_ms();
        answer.octree_checksum = tree_.checksum();
        bytes += answer.image.size() + answer.replaced.size();
        list_bytes += answer.replaced.size();
        whole_bytes += whole;
        if (updates > 1) {
            samples += eliminated.counts.samples, kept += eliminated.counts.kept;
            lost += eliminated.counts.lost;
        }
        removed += eliminated.counts.removed;
        return answer;
    }

    // The client's.
    void take_in(const ppve::Answer& answer) {
        core::Stopwatch watch;
        if (!cache.take_in(answer, double(answer.id)).is_in_step) throw core::Error("out of step");
        take_in_ms += watch.lap_ms();
    }

    double sample_ms = 0, eliminate_ms = 0, encode_ms = 0, insert_ms = 0, take_in_ms = 0;
    uint64_t updates = 0, bytes = 0, list_bytes = 0, first_bytes = 0, whole_bytes = 0, samples = 0, kept = 0,
             lost = 0, removed = 0;

  private:
    ppve::Sampler& sampler_;
    const Options& options_;
    ppve::EliminationRule rule_;
    ppve::Octree tree_;

  public:
    ppve::PointCache cache;
};

std::vector<geom::Camera> path_of(const Options& options) {
    const core::InputFile file(options.path);
    return geom::parse_path({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                            file.name());
}

ppve::Frustum frustum_of(const geom::Camera& camera, const std::array<double, 2>& size) {
    ppve::Frustum frustum{geom::make_view(camera, int(size[0]), int(size[1])), ppve::Projection::perspective};
    frustum.view.near.reset(), frustum.view.far.reset();
    return frustum;
}

// All points of a tree, for searches about some of them.
struct Cloud {
    struct Point {
        float at[3];
        float footprint;
        uint64_t update;
    };
    std::vector<Point> points;

    explicit Cloud(const ppve::Octree& tree) {
        const double unit = tree.shape().unit();
        tree.for_each([&](const ppve::Cluster& cluster) {
            for (const auto& patch : cluster.patches)
                for (size_t i = 0; i < patch->size(); ++i) {
                    const ppve::PatchPoints& p = patch->points();
                    const glm::vec3 offset(p.x[i], p.y[i], p.z[i]);
                    const glm::vec3 at((patch->anchor() - tree.shape().corner) / unit + glm::dvec3(offset));
                    points.push_back(
                        {{at.x, at.y, at.z},
                         patch->footprint_at_anchor() + glm::dot(patch->footprint_slope(), offset),
                         patch->sampling().update});
                }
        });
    }
    size_t kdtree_get_point_count() const { return points.size(); }
    float kdtree_get_pt(size_t i, size_t k) const { return points[i].at[k]; }
    template <class B>
    bool kdtree_get_bbox(B&) const {
        return false;
    }
};

// Of one point in 37: those with an older neighbour that is as fine within half a footprint (duplicates), and
// those with a finer one (coarse leftovers), which is one by more than 1.4.
std::pair<double, double> leftovers(const ppve::Octree& tree) {
    const Cloud cloud(tree);
    using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud, 3>;
    Tree search(3, cloud, {32});
    uint64_t looked = 0, duplicates = 0, coarse = 0;
    for (size_t i = 0; i < cloud.points.size(); i += 37) {
        const Cloud::Point& p = cloud.points[i];
        std::vector<std::pair<uint32_t, float>> near;
        const float radius = 0.5f * p.footprint;
        search.radiusSearch(p.at, radius * radius, near, {});
        bool is_duplicate = false, is_coarse = false;
        for (const auto& [j, distance] : near) {
            const Cloud::Point& q = cloud.points[j];
            is_duplicate |= q.update < p.update && q.footprint <= p.footprint;
            is_coarse |= 1.4f * q.footprint < p.footprint;
        }
        ++looked, duplicates += is_duplicate, coarse += is_coarse;
    }
    return {double(duplicates) / double(looked), double(coarse) / double(looked)};
}

Json traffic(const Options& options, ppve::Sampler& sampler) {
    Updates session(sampler, options);
    for (const geom::Camera& camera : path_of(options)) session.update(frustum_of(camera, options.size));
    const auto [duplicates, coarse] = leftovers(session.cache.tree());
    const double updates = double(session.updates);
    return {{"updates", session.updates},
            {"kb_update", double(session.bytes) / updates / 1000},
            {"kb_whole", double(session.whole_bytes) / updates / 1000},
            {"bytes_by_whole", double(session.bytes) / double(session.whole_bytes)},
            {"list_kb_update", double(session.list_bytes) / updates / 1000},
            {"new_share", double(session.kept) / double(session.samples)},
            {"lost_share", double(session.lost) / double(session.samples)},
            {"duplicates", duplicates},
            {"coarse", coarse},
            {"points", session.cache.tree().points()},
            {"removed", session.removed},
            {"clusters", session.cache.tree().clusters()},
            {"cache_bytes", session.cache.bytes()},
            {"sample_ms", session.sample_ms / updates},
            {"eliminate_ms", session.eliminate_ms / updates},
            {"encode_ms", session.encode_ms / updates},
            {"insert_ms", session.insert_ms / updates},
            {"take_in_ms", session.take_in_ms / updates}};
}

// The camera of a path at a time, between two of its own by their share.
geom::Camera camera_at(const std::vector<geom::Camera>& path, double seconds) {
    const auto after =
        std::find_if(path.begin(), path.end(), [&](const auto& c) { return c.time_s > seconds; });
    if (after == path.begin()) return path.front();
    if (after == path.end()) return path.back();
    const geom::Camera &a = after[-1], &b = *after;
    const double t = (seconds - a.time_s) / (b.time_s - a.time_s);
    geom::Camera camera = a;
    camera.eye += t * (b.eye - a.eye), camera.target += t * (b.target - a.target),
        camera.up += t * (b.up - a.up);
    camera.time_s = seconds;
    return camera;
}

// One frame against the mesh.
struct Judge {
    render::MeshRaster raster;
    render::Look look;
    render::Frame truth;

    explicit Judge(const mesh::Mesh& mesh) : raster(mesh) {}
    render::ImageDifference compare(const geom::View& view, const render::Frame& frame) {
        raster.draw(view, look, truth);
        return render::compare(frame, truth, view.focal_px);
    }
    uint64_t covered() const {
        return uint64_t(
            std::count_if(truth.depth.begin(), truth.depth.end(), [](float z) { return std::isfinite(z); }));
    }
};

// An answer is there one period after its request, when the next request goes out.
Json motion(const Options& options, ppve::Sampler& sampler, const mesh::Mesh& mesh) {
    Updates session(sampler, options);
    Judge judge(mesh);
    ppve::Reconstruction reconstruction;
    const std::vector<geom::Camera> path = path_of(options);
    const double period = 1 / options.rate;
    ppve::EyeTrack track;
    const auto request = [&](double now) {
        geom::Camera camera = camera_at(path, now);
        const geom::View eye = geom::make_view(camera, int(options.screen[0]), int(options.screen[1]));
        double margin = 0;
        if (!options.no_prediction) {
            for (const double t : {now - 0.1, now - 0.05, now})
                if (t >= 0) track.add(t, camera_at(path, t));
            camera = track.at(now + 1.5 * period);
            margin = 0.5 * track.turning_rad_per_s() * period;
        }
        return ppve::frustum_for(camera, ppve::field_of(camera, {&eye, 1}), int(options.size[0]),
                                 int(options.size[1]), margin, 1u << 25);
    };
    // The first picture is complete when the eye sets off, and its surroundings are there.
    session.update(frustum_of(path.front(), options.screen));
    if (!options.no_prediction) {
        const geom::View eye = geom::make_view(path.front(), int(options.screen[0]), int(options.screen[1]));
        session.update(ppve::frustum_for(path.front(), ppve::field_of(path.front(), {&eye, 1}),
                                         int(options.size[0]), int(options.size[1]), ppve::kSurroundings,
                                         1u << 25));
    }
    session.first_bytes = session.bytes;
    ppve::Frustum asked = request(0);
    double next_answer = period, psnr_sum = 0, psnr_least = 1000, empty_sum = 0, empty_most = 0;
    uint64_t frames = 0;
    Json curve = Json::array();
    for (double now = options.frame_s; now <= options.seconds; now += options.frame_s) {
        for (; next_answer <= now; next_answer += period) {
            session.update(asked);
            asked = request(next_answer);
        }
        const geom::View view =
            geom::make_view(camera_at(path, now), int(options.screen[0]), int(options.screen[1]));
        render::Frame frame;
        auto draw = ppve::ReconstructionOptions::of_moving_eye();
        draw.scale = options.scale, draw.ratio = options.ratio, draw.velocity = options.velocity;
        draw.closes_gaps = !options.leaves_gaps;
        reconstruction.draw(*session.cache.model(), {&view, 1}, draw, {&frame, 1});
        const render::ImageDifference d = judge.compare(view, frame);
        const double empty = double(d.holes) / double(std::max<uint64_t>(judge.covered(), 1));
        curve.push_back({{"t", now}, {"psnr_db", d.psnr_db}, {"empty", empty}});
        psnr_sum += d.psnr_db, psnr_least = std::min(psnr_least, d.psnr_db);
        empty_sum += empty, empty_most = std::max(empty_most, empty);
        ++frames;
    }
    Json result{{"rate", options.rate},
                {"predicted", !options.no_prediction},
                {"frames", frames},
                {"psnr_db", psnr_sum / double(frames)},
                {"psnr_db_least", psnr_least},
                {"empty", empty_sum / double(frames)},
                {"empty_most", empty_most},
                {"kb_per_s", double(session.bytes - session.first_bytes) / options.seconds / 1000},
                {"points", session.cache.tree().points()}};
    // Then the eye rests: one update at the client's resolution.
    const geom::View view =
        geom::make_view(camera_at(path, options.seconds), int(options.screen[0]), int(options.screen[1]));
    session.update({view, ppve::Projection::perspective});
    render::Frame frame;
    reconstruction.draw(*session.cache.model(), {&view, 1},
                        ppve::ReconstructionOptions::of_complete_picture(), {&frame, 1});
    const render::ImageDifference d = judge.compare(view, frame);
    result["rest_psnr_db"] = d.psnr_db;
    result["rest_holes"] = d.holes;
    result["curve"] = curve;
    return result;
}

// Limits: --points at the server, 64 bytes for each of them at the client.
Json long_session(const Options& options, ppve::Sampler& sampler) {
    const std::vector<geom::Camera> path = path_of(options);
    const uint64_t most_points = uint64_t(options.points), most_bytes = 64 * most_points;
    ppve::Session server(sampler, "session", {.most_points = most_points});
    ppve::PointCache client(shape_around(sampler.bounds()));
    uint64_t kept_most = 0, bytes_most = 0, tree_bytes_most = 0, evicted = 0, deleted = 0, out_of_step = 0;
    core::Stopwatch watch;
    for (uint64_t id = 1; id <= uint64_t(options.updates); ++id) {
        const geom::Camera camera =
            camera_at(path, path.back().time_s * std::fmod(0.6180339887 * double(id), 1));
        ppve::Request request;
        request.id = id;
        request.frustum = frustum_of(camera, options.size);
        request.last_answer = client.last_answer(), request.octree_checksum = client.tree().checksum();
        request.deletions = client.obsolete(double(id), 1e9, most_bytes);
        server.take(request);
        ppve::AnswerReport report;
        const auto answer = std::get<ppve::Answer>(ppve::parse(server.answer(report), "server"));
        out_of_step += !client.take_in(answer, double(id)).is_in_step;
        evicted += report.evicted, deleted += report.deleted;
        kept_most = std::max(kept_most, server.tree().points());
        tree_bytes_most = std::max(tree_bytes_most, server.tree().bytes());
        bytes_most = std::max(bytes_most, client.bytes());
    }
    return {{"updates", options.updates},
            {"server_points_limit", most_points},
            {"server_points_most", kept_most},
            {"server_bytes_limit", ppve::kPointBytes * most_points},
            {"server_bytes_most", tree_bytes_most},
            {"client_bytes_limit", most_bytes},
            {"client_bytes_most", bytes_most},
            {"evicted_by_server", evicted},
            {"deleted_by_client", deleted},
            {"out_of_step", out_of_step},
            {"s", watch.lap_ms() / 1000}};
}

Json times_of(std::vector<double> ms) {
    std::sort(ms.begin(), ms.end());
    return {{"min", ms.front()},
            {"median", ms[ms.size() / 2]},
            {"p95", ms[size_t(0.95 * double(ms.size() - 1))]}};
}

// Answers that arrive at a rate, taken in by a thread of their own, as ppve::Client has one.
class Arrivals {
  public:
    Arrivals(Updates& session, const std::vector<ppve::Answer>& answers, double rate)
        : model_(session.cache.model()), thread_([this, &session, &answers, rate] {
              const auto start = std::chrono::steady_clock::now();
              for (size_t k = 0; k < answers.size(); ++k) {
                  std::this_thread::sleep_until(
                      start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                  std::chrono::duration<double>(double(k + 1) / rate)));
                  session.take_in(answers[k]);
                  const std::lock_guard lock(mutex_);
                  model_ = session.cache.model();
              }
              are_over_ = true;
          }) {}

    std::shared_ptr<const ppve::PointModel> model() const {
        const std::lock_guard lock(mutex_);
        return model_;
    }
    bool are_over() const { return are_over_; }

  private:
    mutable std::mutex mutex_;
    std::shared_ptr<const ppve::PointModel> model_;
    std::atomic<bool> are_over_ = false;
    std::jthread thread_;
};

double cpu_ms() {
    timespec now;
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

Json draw(const Options& options, ppve::Sampler& sampler) {
    Updates session(sampler, options);
    const std::vector<geom::Camera> path = path_of(options);
    const size_t before = std::max<size_t>(path.size() / 3, 1);
    for (size_t k = 0; k < before; ++k) session.update(frustum_of(path[k], options.screen));
    std::vector<ppve::Answer> answers;
    for (size_t k = before; k < path.size(); ++k)
        answers.push_back(session.answer_to(frustum_of(path[k], options.size)));

    const geom::Camera& eye = path[before - 1];
    const geom::View middle = geom::make_view(eye, int(options.screen[0]), int(options.screen[1]));
    const double distance = glm::length(eye.target - eye.eye);
    const geom::View eyes[2] = {geom::moved_aside(middle, -0.017 * distance, distance),
                                geom::moved_aside(middle, 0.017 * distance, distance)};
    ppve::Reconstruction reconstruction;
    render::Frame frames[2];
    ppve::ReconstructionOptions look;
    look.scale = options.scale, look.velocity = options.velocity, look.most_points = uint64_t(options.points);
    look.closes_gaps = !options.leaves_gaps;
    for (int run = 0; run < 2; ++run) reconstruction.draw(*session.cache.model(), eyes, look, frames);
    std::vector<double> ms;
    std::vector<ppve::ReconstructionCounts> counts;
    session.take_in_ms = 0;
    const double cpu_before = cpu_ms();
    Arrivals arrivals(session, answers, options.rate);
    for (bool is_last = false; !is_last;) {
        is_last = arrivals.are_over();
        core::Stopwatch watch;
        counts = reconstruction.draw(*arrivals.model(), eyes, look, frames);
        ms.push_back(watch.lap_ms());
    }
    return {{"cached", session.cache.tree().points()},
            {"clusters", counts[0].clusters},
            {"patches", counts[0].patches_drawn},
            {"points_an_eye", counts[0].points_chosen},
            {"drawn_an_eye", counts[0].points_drawn},
            {"threads", core::thread_count()},
            {"frames", ms.size()},
            // A frame and its share of what arrives, of all threads' processors.
            {"cpu_ms", (cpu_ms() - cpu_before) / double(ms.size())},
            {"updates", answers.size()},
            {"take_in_ms", session.take_in_ms / double(std::max<size_t>(answers.size(), 1))},
            {"stereo_ms", times_of(ms)}};
}

// The points of the cache in view as squares of the same extent, in the batches that a cut would make.
Json splatter(const Options& options, ppve::Sampler& sampler) {
    Updates session(sampler, options);
    const std::vector<geom::Camera> path = path_of(options);
    for (const geom::Camera& camera : path) session.update(frustum_of(camera, options.size));
    const geom::View view = geom::make_view(path.back(), int(options.screen[0]), int(options.screen[1]));
    std::vector<geom::SplatBatch> batches(1);
    const ppve::Octree& tree = session.cache.tree();
    const double unit = tree.shape().unit();
    uint64_t points = 0;
    tree.for_each([&](const ppve::Cluster& cluster) {
        for (const auto& patch : cluster.patches)
            for (size_t i = 0; i < patch->size(); ++i, ++points) {
                if (batches.back().count == geom::SplatBatch::kCapacity) batches.emplace_back();
                geom::SplatBatch& b = batches.back();
                const ppve::PatchPoints& p = patch->points();
                const glm::vec3 offset(p.x[i], p.y[i], p.z[i]);
                const glm::vec3 at(view.view_from_world(patch->anchor() + glm::dvec3(offset) * unit) / unit);
                const int k = b.count++;
                b.x[k] = at.x, b.y[k] = at.y, b.z[k] = at.z;
                b.radius[k] = 0.5f * static_cast<float>(options.scale) *
                              (patch->footprint_at_anchor() + glm::dot(patch->footprint_slope(), offset));
                b.nx[k] = 0, b.ny[k] = 0, b.nz[k] = -1, b.flatness[k] = 0.1f, b.colour[k] = p.colour[i];
            }
    });
    Json result{{"points", points}, {"threads", core::thread_count()}};
    for (const auto& [name, kind] :
         {std::pair{"square", render::SplatKind::square}, {"ellipse", render::SplatKind::ellipse}}) {
        render::Splatter painter;
        render::SplatterOptions look;
        look.kind = kind, look.has_colour = true, look.depth_unit = unit;
        look.look.shade = render::Shade::flat;
        std::vector<double> ms;
        render::Frame frame;
        for (int64_t run = -1; run < options.runs; ++run) {
            core::Stopwatch watch;
            painter.begin(view, look, batches.size());
            core::parallel_for(batches.size(), [&](size_t task) {
                painter.add(task, batches[task]);
                painter.end_task(task);
            });
            painter.finish(frame);
            if (run >= 0) ms.push_back(watch.lap_ms());
        }
        result[name] = times_of(ms);
    }
    std::vector<double> ms;
    ppve::Reconstruction reconstruction;
    ppve::ReconstructionOptions look;
    look.scale = options.scale, look.most_points = ~uint64_t(0), look.look.shade = render::Shade::flat;
    for (int64_t run = -1; run < options.runs; ++run) {
        render::Frame frame;
        core::Stopwatch watch;
        reconstruction.draw(*session.cache.model(), {&view, 1}, look, {&frame, 1});
        if (run >= 0) ms.push_back(watch.lap_ms());
    }
    result["words"] = times_of(ms);
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("point_view_bench", "Measure the client of remote point sampling.", QS_VERSION);
    Options o;
    program.options.add_option("MESH", o.mesh, "What the server samples")->required();
    program.options.add_option("--path", o.path, "Camera path")->required();
    program.options.add_option("--what", o.what, "traffic, motion, draw, session or splatter");
    program.options.add_option("--eliminate", o.eliminate, "filtered, paper or none");
    program.options.add_option("--rate", o.rate, "Updates a second");
    program.options.add_option("--seconds", o.seconds, "Of motion");
    program.options.add_option("--frame", o.frame_s, "Seconds from frame to frame");
    program.options.add_option("--scale", o.scale, "Of splats");
    program.options.add_option("--rule", o.ratio, "Ratio of the rule for coarse patches");
    program.options.add_option("--velocity", o.velocity, "Of the eye");
    program.options.add_option("--points", o.points, "Budget an eye; of a session, the server's limit");
    program.add_integer("--updates", o.updates, 1, 1'000'000, "Of a session");
    program.options.add_option("--runs", o.runs, "To be timed");
    program.options.add_flag("--no-prediction", o.no_prediction, "Ask for where the eye is");
    program.options.add_flag("--gaps", o.leaves_gaps, "Between splats are left open");
    program.options.add_flag("--normals", o.with_normals, "And light by the client");
    program.add_numbers("--screen", o.screen, "W,H", "The client's resolution");
    program.add_numbers("--size", o.size, "W,H", "The server's resolution");
    return program.run(argc, argv, [&] {
        if (o.what == "motion") o.with_normals = true;
        mesh::Mesh mesh = mesh::read_mesh(o.mesh).mesh;
        ppve::RasterSampler sampler{ppve::Clusters(mesh)};
        Json result = o.what == "motion"     ? motion(o, sampler, mesh)
                      : o.what == "draw"     ? draw(o, sampler)
                      : o.what == "session"  ? long_session(o, sampler)
                      : o.what == "splatter" ? splatter(o, sampler)
                                             : traffic(o, sampler);
        core::print(result.dump() + "\n");
    });
}
