// frame_bench MODEL: measures frames on request.  Each line of standard input is a case, a camera line (see
// camera-path(5)) with these keys more; each is answered by one JSON line on standard output, so that a
// script can choose the next case by the last answer.
//
//     "size"         [width, height], pixels
//     "kind"         "square", "circle", "ellipse" or "smooth"
//     "threshold"    pixels of error, or of diameter with "diameter": true
//     "samples_across"   1, 2 or 4: a pixel is the mean of so many by so many samples
//     "truth_across"     the same for --reference (default: as many)
//     "runs"         frames to time, after a warm-up of 3; 0: the frame is drawn once and not timed
//     "compare"      true: PSNR, growth, holes, ... against --reference, or without it the model's own leaves
//     "distance"     true: the measured error, the largest distance of a pixel's point from --surface
//     "parts"        true: the times of a frame's parts on one thread, task by task, and splats by tile
//
// Times are those of ModelPainter::draw(), from the camera to the shaded pixels; nothing is written.  "ms" is
// by the clock, "processor_ms" what all threads took together.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "render/compare.h"
#include "render/raster.h"
#include "render/splatter.h"
#include "render/tile_bins.h"
#include "scene/backends.h"
#include "scene/draw.h"
#include "scene/reference.h"

namespace {

using core::Json;

constexpr int kWarmUp = 3;

struct Case {
    geom::View view;
    scene::DrawOptions draw;
    int runs = 0;
    bool compare = false, distance = false, parts = false;
    int truth_across = 1;  // samples of what the frame is compared with
};

render::SplatKind kind_of(const std::string& word) {
    static const std::map<std::string, render::SplatKind> kinds = {{"square", render::SplatKind::square},
                                                                   {"circle", render::SplatKind::circle},
                                                                   {"ellipse", render::SplatKind::ellipse},
                                                                   {"smooth", render::SplatKind::smooth}};
    const auto found = kinds.find(word);
    if (found == kinds.end()) throw core::Error("'" + word + "' is no kind of splat");
    return found->second;
}

scene::BackendKind kind_of_backend(const std::string& word) {
    if (word == "osmesa") return scene::BackendKind::osmesa;
    if (word == "egl") return scene::BackendKind::egl;
    return scene::BackendKind::cpu;
}

Case parse_case(const std::string& line) {
    const geom::Camera camera = geom::parse_camera(line, "case");
    const Json json = Json::parse(line);
    Case c;
    c.view = geom::make_view(camera, json.at("size").at(0), json.at("size").at(1));
    c.draw.look.samples_across = json.value("samples_across", 1);
    c.truth_across = json.value("truth_across", c.draw.look.samples_across);
    c.draw.kind = kind_of(json.value("kind", "smooth"));
    c.draw.cut.threshold_px = json.at("threshold");
    c.draw.cut.by = json.value("diameter", false) ? splat::CutBy::diameter : splat::CutBy::error;
    c.draw.occlusion = std::map<std::string, scene::Occlusion>{{"auto", scene::Occlusion::automatic},
                                                               {"on", scene::Occlusion::on},
                                                               {"off", scene::Occlusion::off}}
                           .at(json.value("occlusion", "auto"));
    c.runs = json.value("runs", 0);
    c.compare = json.value("compare", false);
    c.distance = json.value("distance", false);
    c.parts = json.value("parts", false);
    return c;
}

// Median, minimum and spread (distance of the quartiles by the median).
Json summary(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double part) { return values[size_t(part * double(values.size() - 1) + 0.5)]; };
    return {{"median", at(0.5)}, {"min", values.front()}, {"spread", (at(0.75) - at(0.25)) / at(0.5)}};
}

// What is measured against: read and prepared when first asked for.
class Truth {
  public:
    Truth(const splat::Model& model, std::string reference, std::string surface)
        : painter_(model),
          reference_(std::move(reference)),
          surface_(std::move(surface)),
          with_colour_(model.header().flags & (splat::kHasColour | splat::kConstantColour)) {}

    const render::Frame& frame(const geom::View& view, const render::Look& look) {
        std::vector<double> key = key_of(view);
        key.push_back(look.samples_across);
        if (key != drawn_) reference_.empty() ? draw_leaves(view, look) : draw_mesh(view, look);
        drawn_ = key;
        return frame_;
    }

    const mesh::SurfaceDistance& distance() {
        if (!distance_) distance_ = std::make_unique<mesh::SurfaceDistance>(read(surface_, "--surface"));
        return *distance_;
    }

  private:
    void draw_leaves(const geom::View& view, const render::Look& look) {
        scene::DrawOptions leaves;
        leaves.cut.threshold_px = 0;
        leaves.look = look;
        painter_.draw(view, leaves, frame_);
    }

    void draw_mesh(const geom::View& view, const render::Look& look) {
        if (!raster_) {
            mesh_ = read(reference_, "--reference");
            if (!with_colour_) mesh_.colours.clear();
            raster_ = std::make_unique<render::MeshRaster>(mesh_);
        }
        raster_->draw(view, look, frame_);
    }

    static mesh::Mesh read(const std::string& path, const char* option) {
        if (path.empty()) throw core::Error(core::text("a case needs %s, which was not given", option));
        return mesh::read_mesh(path).mesh;
    }

    static std::vector<double> key_of(const geom::View& v) {
        return {double(v.width), double(v.height), v.focal_px, v.eye.x,     v.eye.y,     v.eye.z,
                v.right.x,       v.right.y,        v.right.z,  v.forward.x, v.forward.y, v.forward.z};
    }

    scene::ModelPainter painter_;
    std::string reference_, surface_;
    bool with_colour_;
    mesh::Mesh mesh_;
    std::unique_ptr<render::MeshRaster> raster_;
    std::unique_ptr<mesh::SurfaceDistance> distance_;
    render::Frame frame_;
    std::vector<double> drawn_;
};

// Of all threads: other programs do not count.
double processor_ms() {
    timespec now = {};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

void add_times(Json& answer, const Case& c, scene::ModelPainter& painter, render::Frame& frame) {
    std::vector<double> all, processor, traverse, draw;
    for (int run = 0; run < kWarmUp + c.runs; ++run) {
        const double processor_start = processor_ms();
        const auto start = std::chrono::steady_clock::now();
        const scene::DrawReport report = painter.draw(c.view, c.draw, frame);
        const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
        if (run < kWarmUp) continue;
        all.push_back(ms.count());
        processor.push_back(processor_ms() - processor_start);
        traverse.push_back(report.traverse_ms);
        draw.push_back(report.draw_ms);
    }
    answer["ms"] = summary(all);
    answer["processor_ms"] = summary(processor);
    answer["traverse_ms"] = summary(traverse);
    answer["draw_ms"] = summary(draw);
}

void add_counts(Json& answer, const splat::CutCounts& counts, const splat::Model& model) {
    const splat::Header& h = model.header();
    // Attitude, place and shape; colour where there is a channel.
    const double node_bytes = h.has_colour() ? 6.5 : 4.5;
    answer["nodes_visited"] = counts.nodes_visited;
    answer["frustum_culled"] = counts.frustum_culled;
    answer["backface_culled"] = counts.backface_culled;
    answer["splats"] = counts.splats;
    answer["groups_missing"] = counts.groups_missing;
    answer["visited_bytes"] = node_bytes * double(counts.nodes_visited);
    answer["touched_bytes"] = double(counts.blocks_touched) * h.block_size;
    answer["touched_share"] = double(counts.blocks_touched) / double(h.block_count);
    answer["error_bound_px"] = counts.error_bound_px;
}

// Of all cases so far: what of the file was used, in whole pages of memory, as a map takes them.
double used_bytes(const splat::Model& model, const scene::ModelPainter& painter) {
    const auto page_size = uint64_t(::sysconf(_SC_PAGESIZE));
    uint64_t pages = 1, next = 1;  // the header's
    for (uint64_t block = 0; block < model.blocks_present(); ++block) {
        if (!painter.has_used(0, block)) continue;
        const uint64_t end = model.prefix_bytes(block);
        const uint64_t first = std::max(next, (end - model.header().block_size) / page_size);
        next = std::max(next, (end + page_size - 1) / page_size);
        pages += next > first ? next - first : 0;
    }
    return double(pages * page_size);
}

void add_comparison(Json& answer, const render::Frame& frame, const render::Frame& truth,
                    const geom::View& view) {
    const render::ImageDifference d = render::compare(frame, truth, view.focal_px);
    answer["psnr_db"] = d.psnr_db;
    answer["psnr_inside_db"] = d.psnr_inside_db;
    answer["ssim"] = d.ssim;
    answer["growth"] = d.silhouette_growth;
    answer["holes"] = d.holes;
    answer["holes_inside"] = d.holes_inside;
    answer["show_through"] = d.show_through.value_or(0);
    answer["depth_rmse_px"] = d.depth_rmse_px.value_or(0);
    answer["covered_px"] =
        std::count_if(truth.depth.begin(), truth.depth.end(), [](float z) { return std::isfinite(z); });
}

// Which tile of the picture the middle of each splat is in; those outside count for the nearest.
void count_tiles(const geom::SplatBatch& batch, const geom::View& view, int across, int down,
                 std::vector<uint32_t>& tiles) {
    const auto tile_at = [](double pixel, int size, int count) {
        return int(std::clamp(pixel / size, 0.0, double(count - 1)));
    };
    for (int i = 0; i < batch.count; ++i) {
        const double scale = view.focal_px / std::max(double(batch.z[i]), 1e-30);
        const int x = tile_at(view.principal().x + scale * double(batch.x[i]), render::kTileWidth, across);
        const int y = tile_at(view.principal().y + scale * double(batch.y[i]), render::kTileHeight, down);
        ++tiles[size_t(y) * size_t(across) + size_t(x)];
    }
}

// A frame's parts, one after the other on this thread; finishing runs on as many as there are.
Json parts_of(const Case& c, const splat::Model& model) {
    splat::Cut cut(model);
    render::Splatter splatter;
    render::Frame frame;
    Json parts;
    for (int run = 0; run <= kWarmUp; ++run) {
        core::Stopwatch watch;
        const size_t tasks = cut.begin(c.view, c.draw.cut);
        splatter.begin(c.view, {.kind = c.draw.kind, .look = c.draw.look, .depth_unit = model.header().scale},
                       tasks);
        parts["begin_ms"] = watch.lap_ms();
        std::vector<double> tasks_ms;
        for (size_t task = 0; task < tasks; ++task) {
            cut.run(task, [&](const geom::SplatBatch& batch) { splatter.add(task, batch); });
            splatter.end_task(task);
            tasks_ms.push_back(watch.lap_ms());
        }
        parts["tasks_ms"] = tasks_ms;
        splatter.finish(frame);
        parts["finish_ms"] = watch.lap_ms();
    }
    const int across = (c.view.width + render::kTileWidth - 1) / render::kTileWidth;
    const int down = (c.view.height + render::kTileHeight - 1) / render::kTileHeight;
    std::vector<uint32_t> tiles(size_t(across) * size_t(down), 0);
    const size_t tasks = cut.begin(c.view, c.draw.cut);
    for (size_t task = 0; task < tasks; ++task)
        cut.run(task,
                [&](const geom::SplatBatch& batch) { count_tiles(batch, c.view, across, down, tiles); });
    parts["tile_splats"] = tiles;
    return parts;
}

Json answer_to(const Case& c, const splat::Model& model, scene::ModelPainter& painter, Truth& truth) {
    render::Frame frame;
    Json answer;
    add_counts(answer, painter.draw(c.view, c.draw, frame).counts, model);
    answer["used_bytes"] = used_bytes(model, painter);
    render::Look true_look = c.draw.look;
    true_look.samples_across = c.truth_across;
    if (c.compare) add_comparison(answer, frame, truth.frame(c.view, true_look), c.view);
    if (c.distance) answer["measured_error_px"] = scene::measured_error_px(truth.distance(), c.view, frame);
    if (c.runs > 0) add_times(answer, c, painter, frame);
    if (c.parts) answer["parts"] = parts_of(c, model);
    return answer;
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("frame_bench", "Measure frames of a splat model, a case a line.", QS_VERSION);
    std::string path, reference, surface, backend = "cpu";
    program.options.add_option("MODEL", path, "Splat model")->required();
    program.options.add_option("--reference", reference, "Mesh to compare pictures with");
    program.options.add_option("--surface", surface, "Mesh to measure distances from");
    program.options.add_option("--backend", backend, "What draws: cpu, osmesa or egl");
    return program.run(argc, argv, [&] {
        const splat::Model model(path);
        scene::ModelPainter painter(model, scene::open_backend(kind_of_backend(backend)).painter);
        Truth truth(model, reference, surface);
        std::string line;
        while (std::getline(std::cin, line)) {
            core::print(answer_to(parse_case(line), model, painter, truth).dump() + "\n");
            std::fflush(stdout);
        }
    });
}
