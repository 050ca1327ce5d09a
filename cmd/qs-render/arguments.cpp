#include "qs-render/arguments.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/error.h"

namespace qs_render {

using core::text;
using core::UsageError;

namespace {

constexpr double kMostPixels = 16384;  // a side

template <class T>
struct Word {
    const char* word;
    T value;
};

template <class T, size_t N>
T value_of(const std::string& option, const std::string& word, const Word<T> (&words)[N]) {
    std::string list;
    for (size_t i = 0; i < N; ++i) {
        if (word == words[i].word) return words[i].value;
        list += (i == 0 ? "" : i + 1 == N ? " or " : ", ") + std::string(words[i].word);
    }
    throw UsageError(option + ": '" + word + "' is not " + list);
}

constexpr Word<render::SplatKind> kSplatWords[] = {{"square", render::SplatKind::square},
                                                   {"circle", render::SplatKind::circle},
                                                   {"ellipse", render::SplatKind::ellipse},
                                                   {"smooth", render::SplatKind::smooth}};
constexpr Word<render::Shade> kShadeWords[] = {{"lit", render::Shade::lit},
                                               {"normal", render::Shade::normal},
                                               {"level", render::Shade::level},
                                               {"flat", render::Shade::flat}};
constexpr Word<scene::Occlusion> kOcclusionWords[] = {
    {"auto", scene::Occlusion::automatic}, {"on", scene::Occlusion::on}, {"off", scene::Occlusion::off}};
constexpr Word<render::ImageFormat> kFormatWords[] = {{"png", render::ImageFormat::png},
                                                      {"ppm", render::ImageFormat::ppm},
                                                      {"y4m", render::ImageFormat::y4m},
                                                      {"rgb", render::ImageFormat::rgb}};

constexpr Word<scene::BackendKind> kBackendWords[] = {{"cpu", scene::BackendKind::cpu},
                                                      {"osmesa", scene::BackendKind::osmesa},
                                                      {"egl", scene::BackendKind::egl},
                                                      {"auto", scene::BackendKind::automatic}};

// "R,G,B" or "#rrggbb".
glm::u8vec3 colour_of(const std::string& word) {
    const bool is_hex = word.starts_with('#');
    glm::u8vec3 colour(0);
    const char* at = word.data();
    const char* const end = at + word.size();
    bool is_right = !is_hex || word.size() == 7;
    for (int k = 0; k < 3 && is_right; ++k) {
        if (is_hex ? k == 0 : k > 0) is_right = at < end && *at++ == (is_hex ? '#' : ',');
        const char* const last = is_hex ? at + 2 : end;
        uint8_t value = 0;
        const auto [rest, error] = std::from_chars(at, last, value, is_hex ? 16 : 10);
        is_right = is_right && error == std::errc() && (!is_hex || rest == last);
        colour[k] = value;
        at = rest;
    }
    if (!is_right || at != end)
        throw UsageError("--background: '" + word + "' is not R,G,B with numbers from 0 to 255, or #rrggbb");
    return colour;
}

}  // namespace

void add_options(core::Program& program, Arguments& a) {
    CLI::App& app = program.options;
    CLI::Option* const source =
        app.add_option(
               "SOURCE", a.sources,
               "Splat models, whole or prefixes; - is standard input; FILE@X,Y,Z moves one, see the manual")
            ->required();
    app.add_option("-o,--output", a.output, "Pictures: frame-%04d.png, one file, or - for a stream")
        ->type_name("NAME");
    app.add_option("--format", a.format, "png, ppm, y4m or rgb (default: by the extension, y4m for -)")
        ->type_name("WORD");
    program.add_number("--fps", a.fps, 0.001, 1000, "",
                       "Frames a second, for y4m (default: from the path's times)");
    app.add_option("--depth", a.depth, "Depths as PFM: depth-%04d.pfm, one file, or -")->type_name("NAME");
    app.add_option("--path", a.path, "Camera path, one frame a line; - for standard input")
        ->type_name("FILE");
    a.camera.add_to(program);
    program.add_numbers("--resolution", a.resolution, "W,H", "Size of the picture, 1 to 16384 pixels each");
    a.threshold = program.add_number("--threshold", a.threshold_px, 0, 1e6, "pixels",
                                     "Largest error of what is drawn; 0 draws all detail");
    program.add_number("--threshold-diameter", a.threshold_diameter_px, 0, 1e6, "pixels",
                       "Largest diameter of what is drawn, instead of --threshold");
    app.add_option("--splat", a.splat, "square, circle, ellipse or smooth")->type_name("KIND");
    app.add_option("--shade", a.shade, "lit, normal, level or flat")->type_name("MODE");
    app.add_option("--background", a.background, "R,G,B, 0 to 255 each, or #rrggbb")->type_name("COLOUR");
    app.add_flag("--keep-backfaces", a.keep_backfaces, "Draw also what faces away");
    app.add_option("--occlusion", a.occlusion, "Leave out what surfaces hide: auto, on or off")
        ->type_name("WORD");
    app.add_option("--backend", a.backend, "What draws: cpu, osmesa, egl or auto")->type_name("NAME");
    // Asked for before what is required is missed.
    app.add_flag_callback(
        "--list-backends",
        [&a, source] {
            a.lists_backends = true;
            source->required(false);
        },
        "Say which back ends there are, and exit");
    app.add_option("--reference", a.reference, "Measure each frame against this mesh, for --report")
        ->type_name("MESH");
}

scene::DrawOptions draw_options(const Arguments& a) {
    scene::DrawOptions draw;
    if (a.cuts_by_diameter() && a.threshold->count() > 0)
        throw UsageError("--threshold and --threshold-diameter exclude each other");
    draw.cut.by = a.cuts_by_diameter() ? splat::CutBy::diameter : splat::CutBy::error;
    draw.cut.threshold_px = a.cuts_by_diameter() ? a.threshold_diameter_px : a.threshold_px;
    draw.cut.cull_backfaces = !a.keep_backfaces;
    draw.kind = value_of("--splat", a.splat, kSplatWords);
    draw.shade = value_of("--shade", a.shade, kShadeWords);
    draw.background = colour_of(a.background);
    draw.occlusion = value_of("--occlusion", a.occlusion, kOcclusionWords);
    return draw;
}

render::ImageFormat format_of(const Arguments& a) {
    if (!a.format.empty()) return value_of("--format", a.format, kFormatWords);
    return a.output.empty() ? render::ImageFormat::png : render::format_of_name(a.output);
}

scene::BackendKind backend_of(const Arguments& a) {
    return value_of("--backend", a.backend, kBackendWords);
}

void check(const Arguments& a, const std::vector<Source>& sources) {
    for (const double side : a.resolution)
        if (!(side >= 1 && side <= kMostPixels && side == std::floor(side)))
            throw UsageError(text("--resolution: %g is not a whole number from 1 to %g", side, kMostPixels));
    if (a.output.empty() && a.depth.empty() && a.report.empty())
        throw UsageError("nothing to write; give -o, --depth or --report");
    const auto is_stdin = [](const Source& source) { return source.file == "-"; };
    if (std::any_of(sources.begin(), sources.end(), is_stdin) && a.path == "-")
        throw UsageError("SOURCE and --path are both standard input");
    if (!a.reference.empty() && (sources.size() > 1 || sources[0].is_placed))
        throw UsageError(
            "--reference: measures one model as it stands; draw it alone and without a transform");
    if (a.reference == "-") throw UsageError("--reference: must be a file");
    const std::string camera = a.camera.given();
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
    if (!a.reference.empty() && a.shade == "level")
        throw UsageError("--reference: a mesh has no levels to compare with --shade level");
}

}  // namespace qs_render
