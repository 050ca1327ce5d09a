// backend_bench MODEL [--mesh MESH]: the frame times of each back end, and how far its frames are from the
// CPU's.
//
// One JSON line for each back end and kind of splat, of the whole model seen as the first frame of an orbit;
// and with --mesh one for each that draws triangles, against render::MeshRaster.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "geom/path.h"
#include "gl/mesh_painter.h"
#include "gl/splat_painter.h"
#include "mesh/mesh.h"
#include "render/compare.h"
#include "render/raster.h"
#include "scene/draw.h"

namespace {

using core::Json;

constexpr int kWarmUp = 2;

struct Kind {
    const char* name;
    render::SplatKind kind;
};
constexpr Kind kKinds[] = {{"square", render::SplatKind::square},
                           {"circle", render::SplatKind::circle},
                           {"ellipse", render::SplatKind::ellipse},
                           {"smooth", render::SplatKind::smooth}};

// A context of GL, or null and a line that says why not.
std::unique_ptr<gl::Device> open(const std::string& name) {
    try {
        return std::make_unique<gl::Device>(name == "osmesa" ? gl::make_osmesa_context()
                                                             : gl::make_egl_context(gl::EglPlatform::device));
    } catch (const core::Error& error) {
        core::warn(name + ": " + error.what());
        return nullptr;
    }
}

template <class Draw>
Json times_of(int runs, const Draw& draw) {
    std::vector<double> ms;
    for (int run = 0; run < kWarmUp + runs; ++run) {
        core::Stopwatch watch;
        draw();
        if (run >= kWarmUp) ms.push_back(watch.lap_ms());
    }
    std::sort(ms.begin(), ms.end());
    return {{"median", ms[ms.size() / 2]}, {"min", ms.front()}};
}

Json difference(const render::Frame& frame, const render::Frame& truth, const geom::View& view) {
    const render::ImageDifference d = render::compare(frame, truth, view.focal_px);
    size_t differ = 0;
    for (size_t i = 0; i < frame.rgb.size(); i += 3) {
        int most = 0;
        for (size_t c = i; c < i + 3; ++c) most = std::max(most, std::abs(frame.rgb[c] - truth.rgb[c]));
        differ += most > 1;
    }
    return {{"psnr_db", d.psnr_db},
            {"pixels_differ", double(differ) / double(frame.depth.size())},
            {"holes", d.holes},
            {"holes_inside", d.holes_inside},
            {"growth", d.silhouette_growth},
            {"depth_rmse_px", d.depth_rmse_px.value_or(0)}};
}

void print(Json line) {
    core::print(line.dump() + "\n");
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("backend_bench", "Compare the back ends on one model.", QS_VERSION);
    std::string path, mesh_path;
    int64_t runs = 10, width = 1280, height = 720;
    double threshold_px = 1;
    program.options.add_option("MODEL", path, "Splat model")->required();
    program.options.add_option("--mesh", mesh_path, "Mesh to draw as triangles");
    program.add_integer("--runs", runs, 1, 1000, "Frames to time");
    program.add_integer("--width", width, 1, 16384, "Pixels");
    program.add_integer("--height", height, 1, 16384, "Pixels");
    program.add_number("--threshold", threshold_px, 0, 1e6, "pixels", "Largest error of what is drawn");
    return program.run(argc, argv, [&] {
        const splat::Model model(path);
        geom::Shot shot;
        shot.frames = 1;
        shot.aspect = double(width) / double(height);
        const geom::Sphere bounds{model.header().origin, model.header().scale};
        const geom::View view = geom::make_view(geom::orbit(bounds, shot).front(), int(width), int(height));
        std::vector<render::Frame> truths(std::size(kKinds));
        for (const std::string name : {"cpu", "osmesa", "egl"}) {
            std::unique_ptr<render::SplatPainter> splats = std::make_unique<render::Splatter>();
            std::string renderer = "cpu";
            if (name != "cpu") {
                std::unique_ptr<gl::Device> device = open(name);
                if (!device) continue;
                renderer = device->renderer();
                splats = std::make_unique<gl::SplatPainter>(std::move(device));
            }
            scene::ModelPainter painter(model, std::move(splats));
            for (size_t k = 0; k < std::size(kKinds); ++k) {
                scene::DrawOptions options;
                options.kind = kKinds[k].kind;
                options.cut.threshold_px = threshold_px;
                render::Frame frame;
                uint64_t count = 0;
                const Json ms =
                    times_of(int(runs), [&] { count = painter.draw(view, options, frame).counts.splats; });
                if (name == "cpu") truths[k] = frame;
                print({{"backend", name},
                       {"renderer", renderer},
                       {"kind", kKinds[k].name},
                       {"splats", count},
                       {"ms", ms},
                       {"against_cpu", difference(frame, truths[k], view)}});
            }
        }
        if (mesh_path.empty()) return;
        const mesh::Mesh mesh = mesh::read_mesh(mesh_path).mesh;
        render::Frame truth;
        for (const std::string name : {"cpu", "osmesa", "egl"}) {
            std::unique_ptr<render::MeshPainter> painter;
            if (name == "cpu") {
                painter = std::make_unique<render::MeshRaster>(mesh);
            } else if (std::unique_ptr<gl::Device> device = open(name)) {
                painter = std::make_unique<gl::MeshPainter>(std::move(device), mesh);
            } else {
                continue;
            }
            render::Frame frame;
            const Json ms = times_of(int(runs), [&] { painter->draw(view, {}, frame); });
            if (name == "cpu") truth = frame;
            print({{"backend", name},
                   {"triangles", mesh.triangles.size()},
                   {"ms", ms},
                   {"against_cpu", difference(frame, truth, view)}});
        }
    });
}
