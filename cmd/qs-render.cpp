// qs-render: draw the frames of a camera path.  The work is scene::ModelPainter and scene::Reference.
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "core/stopwatch.h"
#include "geom/path.h"
#include "mesh/mesh.h"
#include "render/image.h"
#include "scene/draw.h"
#include "scene/frame_report.h"
#include "scene/outputs.h"
#include "scene/reference.h"

namespace {

using core::text;
using core::UsageError;

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();
constexpr double kMostPixels = 16384;  // a side
constexpr double kMostDegrees = 179;

// The camera of a single frame.
struct CameraOptions {
    std::array<double, 3> position{kNotGiven, kNotGiven, kNotGiven};
    std::array<double, 3> focal_point{kNotGiven, kNotGiven, kNotGiven};
    std::array<double, 3> view_up{0, 1, 0};
    double view_angle_deg = 30, azimuth_deg = 0, elevation_deg = 15;
    std::vector<CLI::Option*> all;
    CLI::Option *azimuth = nullptr, *elevation = nullptr;

    void add_to(core::Program& program) {
        const double turn = 360, pole = 90;
        azimuth = program.add_number("--camera-azimuth-angle", azimuth_deg, -turn, turn, "degrees",
                                     "Side to look from: 0 the front, 90 the model's +X");
        elevation = program.add_number("--camera-elevation-angle", elevation_deg, -pole, pole, "degrees",
                                       "Height of the eye over the focal point");
        all = {program.add_numbers("--camera-position", position, "X,Y,Z",
                                   "The eye (default: so far off that the model fits)"),
               program.add_numbers("--camera-focal-point", focal_point, "X,Y,Z",
                                   "Point in the middle of the picture (default: the model's centre)"),
               program.add_numbers("--camera-view-up", view_up, "X,Y,Z", "What points up in the picture"),
               program.add_number("--camera-view-angle", view_angle_deg, 0.001, kMostDegrees, "degrees",
                                  "Vertical field of view"),
               azimuth,
               elevation};
    }

    // Names the first of the options that was given, if any was.
    std::string given() const {
        for (const CLI::Option* option : all)
            if (option->count() > 0) return option->get_name();
        return "";
    }

    geom::Camera camera(geom::Sphere bounds, double aspect) const {
        if (!std::isnan(focal_point[0])) bounds.centre = {focal_point[0], focal_point[1], focal_point[2]};
        const glm::dvec3 up{view_up[0], view_up[1], view_up[2]};
        if (up == glm::dvec3(0)) throw UsageError("--camera-view-up: 0,0,0 is no direction");
        if (std::isnan(position[0])) {
            const geom::Shot shot{1, geom::kDefaultFps, view_angle_deg, aspect, up};
            return geom::orbit(bounds, shot, {1, azimuth_deg, elevation_deg}).front();
        }
        for (const CLI::Option* angle : {azimuth, elevation})
            if (angle->count() > 0)
                throw UsageError(angle->get_name() +
                                 ": not with --camera-position, which says where the eye is");
        geom::Camera camera;
        camera.eye = {position[0], position[1], position[2]};
        camera.target = bounds.centre;
        camera.up = up;
        camera.fovy_deg = view_angle_deg;
        try {
            geom::check(camera);
        } catch (const core::Error& error) {
            throw UsageError(std::string("--camera-position: ") + error.what());
        }
        return camera;
    }
};

// All that the command line can say.
struct Arguments {
    std::string source, path, output, format, depth, reference, report;
    CameraOptions camera;
    std::array<double, 2> resolution{1280, 720};
    double threshold_px = 1, threshold_diameter_px = kNotGiven, fps = kNotGiven;
    CLI::Option* threshold = nullptr;
    bool keep_backfaces = false;
    std::string splat = "smooth", shade = "lit", background = "0,0,0";

    bool cuts_by_diameter() const { return !std::isnan(threshold_diameter_px); }
};

void add_options(core::Program& program, Arguments& a) {
    CLI::App& app = program.options;
    app.add_option("SOURCE", a.source, "Splat model, whole or a prefix of one; - for standard input")
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
    app.add_option("--reference", a.reference, "Measure each frame against this mesh, for --report")
        ->type_name("MESH");
}

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
constexpr Word<render::ImageFormat> kFormatWords[] = {{"png", render::ImageFormat::png},
                                                      {"ppm", render::ImageFormat::ppm},
                                                      {"y4m", render::ImageFormat::y4m},
                                                      {"rgb", render::ImageFormat::rgb}};

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
    return draw;
}

render::ImageFormat format_of(const Arguments& a) {
    if (!a.format.empty()) return value_of("--format", a.format, kFormatWords);
    return a.output.empty() ? render::ImageFormat::png : render::format_of_name(a.output);
}

// What can be told without reading anything.
void check(const Arguments& a) {
    for (const double side : a.resolution)
        if (!(side >= 1 && side <= kMostPixels && side == std::floor(side)))
            throw UsageError(text("--resolution: %g is not a whole number from 1 to %g", side, kMostPixels));
    if (a.output.empty() && a.depth.empty() && a.report.empty())
        throw UsageError("nothing to write; give -o, --depth or --report");
    if (a.source == "-" && a.path == "-") throw UsageError("SOURCE and --path are both standard input");
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
    for (const std::string& name : {a.output, a.depth}) render::has_frame_number(name);
    if (!a.reference.empty() && a.shade == "level")
        throw UsageError("--reference: a mesh has no levels to compare with --shade level");
}

std::vector<geom::Camera> cameras_of(const Arguments& a, const splat::Model& model) {
    if (a.path.empty()) {
        const geom::Sphere bounds{model.header().origin, model.header().scale};
        return {a.camera.camera(bounds, a.resolution[0] / a.resolution[1])};
    }
    const core::InputFile file(a.path);
    return geom::parse_path({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                            file.name());
}

// The rate at which the path's times pass.
double frames_per_s(const Arguments& a, const std::vector<geom::Camera>& path) {
    if (!std::isnan(a.fps)) return a.fps;
    const double fps = double(path.size() - 1) / (path.back().time_s - path.front().time_s);
    return fps >= 0.001 && fps <= 1000 ? fps : geom::kDefaultFps;
}

std::unique_ptr<scene::Reference> reference_of(const Arguments& a, const splat::Model& model) {
    if (a.reference.empty()) return nullptr;
    const bool has_colour = model.header().flags & (splat::kHasColour | splat::kConstantColour);
    auto reference =
        std::make_unique<scene::Reference>(mesh::read_mesh(a.reference).mesh, a.reference, has_colour);
    if (has_colour && !reference->has_colour())
        core::warn(a.reference + ": has no colours, unlike the model; its frames are grey");
    return reference;
}

void draw_frames(const Arguments& a, const scene::DrawOptions& draw, const splat::Model& model,
                 const std::vector<geom::Camera>& path) {
    core::Report report({a.source, a.path, a.reference});
    render::FrameWriter writer(a.output, format_of(a), frames_per_s(a, path));
    const std::unique_ptr<scene::Reference> reference = reference_of(a, model);
    scene::ModelPainter painter(model);
    render::Frame frame;
    core::Progress progress("frame", path.size());
    // The default is a wish that small models cannot meet; squares and circles have no bound to hold against
    // it; of a prefix has been warned.
    const bool warns_of_leaves =
        a.threshold->count() > 0 && model.is_complete() &&
        (draw.kind == render::SplatKind::ellipse || draw.kind == render::SplatKind::smooth);
    size_t coarse_count = 0;
    for (size_t i = 0; i < path.size(); ++i) {
        const geom::View view = geom::make_view(path[i], int(a.resolution[0]), int(a.resolution[1]));
        scene::FrameReport line;
        line.frame = int(i);
        line.time_s = path[i].time_s;
        line.cut = draw.cut;
        line.draw = painter.draw(view, draw, frame);
        core::Stopwatch watch;
        if (!a.output.empty()) writer.write(int(i), frame);
        if (!a.depth.empty()) writer.write_depth(a.depth, int(i), frame);
        line.write_ms = watch.lap_ms();
        if (reference) {
            line.reference = reference->measure(view, draw.shade, draw.background, frame);
            line.reference_ms = watch.lap_ms();
        }
        if (report.is_wanted()) report.write(scene::to_json(line, model));
        coarse_count += warns_of_leaves && line.misses_threshold();
        progress.update(i + 1);
    }
    writer.finish();
    report.commit();
    if (coarse_count > 0)
        core::warn(text("threshold %g px not met in %zu of %zu frames: the model's leaves are coarser",
                        draw.cut.threshold_px, coarse_count, path.size()));
}

void run(const Arguments& a) {
    check(a);
    const scene::DrawOptions draw = draw_options(a);
    const splat::Model model(a.source);
    const std::vector<geom::Camera> path = cameras_of(a, model);
    scene::check({a.output, a.depth, format_of(a), a.report}, std::array{a.source, a.path, a.reference},
                 path.size());
    if (!model.is_complete())
        core::warn(text("%s: holds %llu of %llu blocks; what is drawn is as fine as they are",
                        model.name().c_str(), static_cast<unsigned long long>(model.blocks_present()),
                        static_cast<unsigned long long>(model.header().block_count)));
    draw_frames(a, draw, model, path);
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("qs-render", "Draw the frames of a camera path from a splat model.", QS_VERSION);
    Arguments arguments;
    add_options(program, arguments);
    return program.run(argc, argv, [&] {
        arguments.report = program.options.get_option("--report")->as<std::string>();
        run(arguments);
    });
}
