#include "qs-view/arguments.h"

#include <cmath>

#include "core/error.h"
#include "core/file.h"
#include "render/image.h"
#include "scene/drawing_words.h"

namespace qs_view {

using core::text;
using core::UsageError;

namespace {

constexpr double kMostPixels = 16384;  // a side of the window

}  // namespace

void add_options(core::Program& program, Arguments& a) {
    CLI::App& app = program.options;
    app.add_option("SOURCE", a.sources,
                   "Models: files, http://..., FILE@X,Y,Z; meshes; or one .pm, pm://..., ppve://...");
    a.camera.add_to(program);
    program.add_numbers("--resolution", a.resolution, "W,H", "Size of the window, pixels");
    program.add_number("--threshold", a.threshold_px, 0.01, 1e6, "pixels",
                       "Largest error of a picture at rest");
    program.add_duration("--budget", a.budget_ms, 1, 1e4, "Time for a frame while the camera moves");
    app.add_option("--splat", a.splat, "square, circle, ellipse or smooth")
        ->check(scene::splat_kinds())
        ->type_name("KIND");
    app.add_option("--shade", a.shade, "lit, normal, level or flat")
        ->check(scene::shades())
        ->type_name("MODE");
    program.add_numbers("--key-light", a.key_light, "X,Y,Z", "Light from there, and less from the eye");
    app.add_option("--background", a.background, "R,G,B, 0 to 255 each, or #rrggbb")->type_name("COLOUR");
    app.add_option("--backend", a.backend, "What draws: cpu, osmesa, egl or auto")
        ->check(scene::backend_kinds())
        ->type_name("NAME");
    app.add_option("--cache", a.cache, "Folder of qs-fetch's cache")->type_name("DIR");
    app.add_option("--record", a.record, "Record the camera from the start, as a path")->type_name("FILE");
    app.add_option("--screenshot", a.screenshot, "Write the first view once it is complete, and quit")
        ->type_name("FILE");
    app.add_flag("--hide-status", a.hide_status, "Begin without the status line");
}

void check(const Arguments& a) {
    for (const double side : a.resolution)
        if (!(side >= 1 && side <= kMostPixels && side == std::floor(side)))
            throw UsageError(text("--resolution: %g is not a whole number from 1 to %g", side, kMostPixels));
    if (!a.screenshot.empty() && a.sources.empty()) throw UsageError("--screenshot: needs a SOURCE");
    if (!a.screenshot.empty() && a.screenshot != "-" &&
        render::format_of_name(a.screenshot) != render::ImageFormat::png)
        throw UsageError("--screenshot: '" + a.screenshot + "' is not the name of a .png");
    for (const std::string& source : a.sources)
        for (const std::string& output : {a.record, a.screenshot})
            if (!output.empty() && core::same_file(source, output))
                throw UsageError("'" + output + "' is a SOURCE, which would be overwritten");
    look_of(a);
    subject_options(a);
}

render::Look look_of(const Arguments& a) {
    render::Look look;
    look.shade = scene::shade_of("--shade", a.shade);
    const glm::u8vec4 background = scene::colour_of("--background", a.background);
    if (background.a < 255)
        throw UsageError("--background: '" + a.background + "' is transparent, which a window is not");
    look.background = glm::u8vec3(background);
    look.key_light = scene::key_light_of("--key-light", a.key_light);
    return look;
}

view::SubjectOptions subject_options(const Arguments& a) {
    view::SubjectOptions options;
    options.backend = scene::backend_kind_of("--backend", a.backend);
    options.splat = scene::splat_kind_of("--splat", a.splat);
    options.cache = a.cache;
    options.width = int(a.resolution[0]), options.height = int(a.resolution[1]);
    return options;
}

}  // namespace qs_view
