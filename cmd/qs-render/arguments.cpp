#include "qs-render/arguments.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/program.h"
#include "core/words.h"
#include "scene/drawing_words.h"

namespace qs_render {

using core::text;
using core::UsageError;
using core::value_of;
using core::Word;

namespace {

constexpr double kMostPixels = 16384;         // a side, of what is drawn at once
constexpr double kMostPicturePixels = 32768;  // a side, of a picture that a tile is of

constexpr Word<scene::Occlusion> kOcclusionWords[] = {
    {"auto", scene::Occlusion::automatic}, {"on", scene::Occlusion::on}, {"off", scene::Occlusion::off}};
constexpr Word<render::ImageFormat> kFormatWords[] = {{"png", render::ImageFormat::png},
                                                      {"ppm", render::ImageFormat::ppm},
                                                      {"y4m", render::ImageFormat::y4m},
                                                      {"rgb", render::ImageFormat::rgb}};

// An empty word is a variable that was not set, or a slip: not as if nothing had been said.
const CLI::Validator kNotEmpty(
    [](const std::string& word) { return std::string(word.empty() ? "is empty" : ""); }, "");

constexpr Word<int> kSampleWords[] = {{"1", 1}, {"4", 2}, {"16", 4}};  // each way

// An explanation is of one frame, and goes to standard output.
void check_explanation(const Arguments& a) {
    const std::pair<const char*, bool> others[] = {
        {"-o", !a.output.empty()},       {"--depth", !a.depth.empty()},
        {"--report", !a.report.empty()}, {"--reference", !a.reference.empty()},
        {"--budget", a.has_budget()},    {"--refine", a.refine}};
    for (const auto& [option, is_given] : others)
        if (is_given)
            throw UsageError(std::string(option) + (a.explain ? ": not with --explain, which draws no picture"
                                                              : ": not with --plan, which draws no picture"));
}

}  // namespace

void add_options(core::Program& program, Arguments& a) {
    CLI::App& app = program.options;
    CLI::Option* const source =
        app.add_option("SOURCE", a.sources,
                       "Models: files, -, http://..., FILE@X,Y,Z; or one .pm, pm://..., ppve://...")
            ->required();
    app.add_option("-o,--output", a.output, "Pictures: frame-%04d.png, one file, or - for a stream")
        ->check(kNotEmpty)
        ->type_name("NAME");
    app.add_option("--format", a.format, "png, ppm, y4m or rgb (default: by the extension, y4m for -)")
        ->check(core::one_of(kFormatWords))
        ->type_name("WORD");
    program.add_number("--fps", a.fps, 0.001, 1000, "",
                       "Frames a second, for y4m (default: from the path's times)");
    app.add_option("--depth", a.depth, "Depths as PFM: depth-%04d.pfm, one file, or -")
        ->check(kNotEmpty)
        ->type_name("NAME");
    app.add_option("--path", a.path, "Camera path, one frame a line; - for standard input")
        ->check(kNotEmpty)
        ->type_name("FILE");
    a.camera.add_to(program);
    app.add_option("--frames", a.frames, "Draw only these of the path: from A up to, not including, B")
        ->check(kNotEmpty)
        ->type_name("A:B");
    program.add_numbers("--resolution", a.resolution, "W,H", "Size of the picture, 1 to 16384 pixels each");
    app.add_option("--tile", a.tile, "Draw column X, row Y of the picture cut into NX x NY tiles")
        ->check(kNotEmpty)
        ->type_name("X,Y/NX,NY");
    app.add_flag("--stereo", a.is_stereo,
                 "Draw for two eyes, side by side, or into two files: %s in the name");
    a.eye_angle = program.add_number("--eye-angle", a.eye_angle_deg, 0.001, 90, "degrees",
                                     "Between the eyes, as seen from the focal point");
    a.threshold = program.add_number("--threshold", a.threshold_px, 0, 1e6, "pixels",
                                     "Largest error of what is drawn; 0 draws all detail");
    program.add_number("--threshold-diameter", a.threshold_diameter_px, 0, 1e6, "pixels",
                       "Largest diameter of what is drawn, instead of --threshold");
    program.add_number("--triangle-size", a.triangle_px, 0, 1e6, "pixels",
                       "Least size of a leaf drawn as a triangle, if it is one");
    program.add_duration("--budget", a.budget_ms, 0.001, 3.6e6,
                         "Time for a frame, 33ms: --threshold rises to keep it");
    app.add_flag("--refine", a.refine, "Draw each camera several times, finer and finer, for --report");
    app.add_option("--splat", a.splat, "square, circle, ellipse or smooth")
        ->check(scene::splat_kinds())
        ->type_name("KIND");
    app.add_option("--shade", a.shade, "lit, normal, level or flat")
        ->check(scene::shades())
        ->type_name("MODE");
    app.add_option("--samples", a.samples, "Samples a pixel: 1, 4 or 16")
        ->check(core::one_of(kSampleWords))
        ->type_name("N");
    program.add_numbers("--key-light", a.key_light, "X,Y,Z", "Light from there, and less from the eye");
    app.add_option("--background", a.background, "R,G,B, 0 to 255 each, #rrggbb, #rrggbbaa, or none")
        ->type_name("COLOUR");
    app.add_flag("--keep-backfaces", a.keep_backfaces, "Draw also what faces away");
    app.add_option("--occlusion", a.occlusion, "Leave out what surfaces hide: auto, on or off")
        ->check(core::one_of(kOcclusionWords))
        ->type_name("WORD");
    app.add_option("--backend", a.backend, "What draws: cpu, osmesa, egl or auto")
        ->check(scene::backend_kinds())
        ->type_name("NAME");
    // Asked for before what is required is missed.
    app.add_flag_callback(
        "--list-backends",
        [&a, source] {
            a.lists_backends = true;
            source->required(false);
        },
        "Say which back ends there are, and exit");
    app.add_flag("--explain", a.explain,
                 "Say what the first frame needs and leaves out, and why; draw nothing");
    app.add_flag("--json", a.json, "With --explain, --plan: as JSON, keys as in qs-render(1)");
    app.add_flag("--keep-going", a.keep_going,
                 "Skip frames that cannot be drawn, and exit with 1 at the end");
    app.add_option("--reference", a.reference, "Measure each frame against this mesh, for --report")
        ->check(kNotEmpty)
        ->type_name("MESH");
    app.add_option_function<std::string>(
           "--ppve-command",
           [&a, source](const std::string& command) {
               a.ppve_command = command;
               source->required(false);
           },
           "Draw the points that this command serves: 'ssh host ppve-sample a.ply'")
        ->check(kNotEmpty)
        ->type_name("COMMAND");
    app.add_option("--ppve", a.ppve, "How points are asked for and drawn: realtime,size=1280x800,...")
        ->check(kNotEmpty)
        ->type_name("SETTINGS");
    a.streaming.add_to(program);
}

bool Arguments::threshold_is_given() const {
    return threshold->count() > 0;
}

scene::DrawOptions draw_options(const Arguments& a) {
    scene::DrawOptions draw;
    if (a.cuts_by_diameter() && a.threshold_is_given())
        throw UsageError("--threshold and --threshold-diameter exclude each other");
    draw.cut.by = a.cuts_by_diameter() ? splat::CutBy::diameter : splat::CutBy::error;
    draw.cut.threshold_px = a.cuts_by_diameter() ? a.threshold_diameter_px : a.threshold_px;
    draw.cut.cull_backfaces = !a.keep_backfaces;
    draw.cut.triangle_px = a.triangle_px;
    draw.kind = scene::splat_kind_of("--splat", a.splat);
    draw.look.shade = scene::shade_of("--shade", a.shade);
    const glm::u8vec4 background = scene::colour_of("--background", a.background);
    draw.look.background = glm::u8vec3(background);
    draw.look.background_alpha = background.a;
    draw.look.samples_across = value_of("--samples", a.samples, kSampleWords);
    draw.look.key_light = scene::key_light_of("--key-light", a.key_light);
    draw.occlusion = value_of("--occlusion", a.occlusion, kOcclusionWords);
    return draw;
}

scene::Screen screen(const Arguments& a) {
    scene::Screen screen;
    screen.width = int(a.resolution[0]), screen.height = int(a.resolution[1]);
    if (!a.tile.empty()) screen.tile = parse_tile(a.tile);
    screen.is_stereo = a.is_stereo;
    screen.eye_angle_deg = a.eye_angle_deg;
    return screen;
}

FrameRange frame_range(const Arguments& a) {
    return a.frames.empty() ? FrameRange{} : parse_frames(a.frames);
}

render::ImageFormat format_of(const Arguments& a) {
    if (!a.format.empty()) return value_of("--format", a.format, kFormatWords);
    return a.output.empty() ? render::ImageFormat::png : render::format_of_name(a.output);
}

scene::BackendKind backend_of(const Arguments& a) {
    const scene::BackendKind kind = scene::backend_kind_of("--backend", a.backend);
    if (draw_options(a).look.samples_across == 1 || kind == scene::BackendKind::cpu) return kind;
    if (kind == scene::BackendKind::automatic) return scene::BackendKind::cpu;
    throw UsageError("--samples: back end " + a.backend + " draws one sample a pixel; the CPU draws more");
}

namespace {

void check_sizes(const Arguments& a) {
    const double most = a.tile.empty() ? kMostPixels : kMostPicturePixels;
    for (const double side : a.resolution)
        if (!(side >= 1 && side <= most && side == std::floor(side)))
            throw UsageError(
                text("--resolution: %g is not a whole number from 1 to %g%s", side, most,
                     side > kMostPixels && side <= kMostPicturePixels ? "; draw it by --tile" : ""));
    const scene::Tile tile = screen(a).tile;
    if (tile.across > a.resolution[0] || tile.down > a.resolution[1])
        throw UsageError(text("--tile: %g x %g pixels cannot be cut into %d x %d tiles", a.resolution[0],
                              a.resolution[1], tile.across, tile.down));
    const double width = std::ceil(a.resolution[0] / tile.across),
                 height = std::ceil(a.resolution[1] / tile.down);
    if (width > kMostPixels || height > kMostPixels)
        throw UsageError(text("--tile: tiles of %g x %g pixels; at most %g x %g, cut the picture into more",
                              width, height, kMostPixels, kMostPixels));
    const int across = value_of("--samples", a.samples, kSampleWords);
    for (const double side : a.resolution)
        if (side * across > render::kMostSamples)
            throw UsageError(
                text("--samples: %s in a picture of %g x %g pixels; at most %d a side with so many",
                     a.samples.c_str(), a.resolution[0], a.resolution[1], render::kMostSamples / across));
}

void check_budget(const Arguments& a) {
    if (a.has_budget() && !a.tile.empty())
        throw UsageError("--budget: not with --tile; tiles whose thresholds are chosen by time have seams");
}

void check_stereo(const Arguments& a) {
    if (!a.is_stereo && a.eye_angle->count() > 0) throw UsageError("--eye-angle: needs --stereo");
    for (const std::string& name : {a.output, a.depth}) {
        if (!a.is_stereo && render::has_eye(name))
            throw UsageError("'" + name + "': %s is the place for the eye; needs --stereo");
        if (a.is_stereo && !name.empty() && !a.tile.empty() && !render::has_eye(name))
            throw UsageError("--tile: with --stereo each eye has its own; put %s into '" + name + "'");
    }
    if (a.is_stereo && a.tile.empty() && 2 * a.resolution[0] > kMostPicturePixels)
        throw UsageError(text("--stereo: two pictures %g pixels wide; at most %g", a.resolution[0],
                              kMostPicturePixels / 2));
}

void check_look(const Arguments& a) {
    const render::Look look = draw_options(a).look;
    if (look.samples_across > 1 && a.occlusion == "on")
        throw UsageError("--occlusion on: only with one sample a pixel, --samples 1");
    if (look.has_alpha() && !a.output.empty() && format_of(a) != render::ImageFormat::png)
        throw UsageError("--background: '" + a.background + "' is transparent, which only PNG can hold");
}

}  // namespace

void check(const Arguments& a, const std::vector<Source>& sources) {
    check_sizes(a);
    check(a.streaming, sources, !a.path.empty());
    if (a.explain || a.streaming.plan) {
        check_explanation(a);
    } else if (a.output.empty() && a.depth.empty() && a.report.empty()) {
        throw UsageError("nothing to write; give -o, --depth or --report");
    }
    if (a.json && !a.explain && !a.streaming.plan) throw UsageError("--json: needs --explain or --plan");
    const auto is_stdin = [](const Source& source) { return source.file == "-"; };
    if (std::any_of(sources.begin(), sources.end(), is_stdin) && a.path == "-")
        throw UsageError("SOURCE and --path are both standard input");
    if (!a.reference.empty() && (sources.size() > 1 || sources[0].is_placed))
        throw UsageError(
            "--reference: measures one model as it stands; draw it alone and without a transform");
    if (a.reference == "-") throw UsageError("--reference: must be a file");
    const std::string camera = a.camera.given();
    if (!a.frames.empty() && a.path.empty()) throw UsageError("--frames: needs --path");
    frame_range(a);
    if (!a.path.empty() && !camera.empty())
        throw UsageError(camera + ": not with --path, which has the cameras");
    if (int(a.output == "-") + int(a.depth == "-") + int(a.report == "-") > 1)
        throw UsageError("-o, --depth and --report: only one of them can be standard output");
    if (!a.output.empty() && a.output == a.depth)
        throw UsageError("--depth: '" + a.depth + "' is the name of the pictures");
    if (!a.reference.empty() && a.report.empty())
        throw UsageError("--reference: its measures go to --report, which is not given");
    format_of(a);
    backend_of(a);
    for (const std::string& name : {a.output, a.depth}) render::has_frame_number(name);
    check_budget(a);
    check_stereo(a);
    check_look(a);
    if (!a.reference.empty() && a.shade == "level")
        throw UsageError("--reference: a mesh has no levels to compare with --shade level");
}

}  // namespace qs_render
