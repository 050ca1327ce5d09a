// The command line of qs-render.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/program_fwd.h"
#include "qs-render/parts.h"
#include "qs-render/streaming.h"
#include "render/image.h"
#include "scene/backends.h"
#include "scene/camera_options.h"
#include "scene/draw.h"
#include "scene/sources.h"

namespace qs_render {

using scene::kNotGiven;
using scene::Source;

// All that the command line can say.
struct Arguments {
    std::vector<std::string> sources;
    std::string path, output, format, depth, reference, report;
    scene::CameraOptions camera;
    std::array<double, 2> resolution{1280, 720};
    double triangle_px = scene::kTrianglePx;
    double threshold_px = 1, threshold_diameter_px = kNotGiven, budget_ms = kNotGiven, fps = kNotGiven;
    CLI::Option* threshold = nullptr;
    bool refine = false, keep_backfaces = false, keep_going = false, is_stereo = false, explain = false,
         json = false;
    std::string frames, tile, samples = "1";
    std::array<double, 3> key_light{kNotGiven, kNotGiven, kNotGiven};
    double eye_angle_deg = 2;
    CLI::Option* eye_angle = nullptr;
    std::string splat = "smooth", shade = "lit", background = "0,0,0", occlusion = "auto";
    std::string backend = "auto";
    StreamingOptions streaming;
    bool lists_backends = false;     // and does nothing else
    std::string ppve_command, ppve;  // a server of points, and how it is asked

    bool threshold_is_given() const;
    bool cuts_by_diameter() const { return !std::isnan(threshold_diameter_px); }
    bool has_budget() const { return !std::isnan(budget_ms); }
};

void add_options(core::Program& program, Arguments& arguments);

// What can be told without reading models.  Throws core::UsageError.
void check(const Arguments& arguments, const std::vector<Source>& sources);

// These throw core::UsageError for words that they do not know.
scene::DrawOptions draw_options(const Arguments& arguments);
scene::Screen screen(const Arguments& arguments);
FrameRange frame_range(const Arguments& arguments);
render::ImageFormat format_of(const Arguments& arguments);
scene::BackendKind backend_of(const Arguments& arguments);

}  // namespace qs_render
