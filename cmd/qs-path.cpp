// qs-path: make camera paths.  The paths are those of geom/path.h; here are their options.
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "core/words.h"
#include "geom/path.h"
#include "mesh/mesh.h"
#include "scene/model_beginning.h"
#include "scene/remote_models.h"
#include "splat/format.h"

namespace {

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();
constexpr double kFarthest = 1e12, kNearest = 1e-12;  // factors of distance

std::optional<double> if_given(double value) {
    return std::isnan(value) ? std::nullopt : std::optional(value);
}

// What a path is made for: a model, a mesh or bounds.
struct Scene {
    std::string model, cache;
    std::array<double, 4> bounds{kNotGiven, kNotGiven, kNotGiven, kNotGiven};

    void add_to(CLI::App& app) {
        app.add_option("MODEL", model,
                       "A splat model or its URL, a mesh or point cloud; - for standard input");
        app.add_option("--cache", cache, "Folder of qs-fetch's cache")->type_name("DIR");
        core::add_numbers(app, "--bounds", bounds, "X,Y,Z,R",
                          "Centre and radius of what is to be seen, instead of MODEL");
    }

    geom::Sphere sphere() const {
        const bool has_bounds = !std::isnan(bounds[3]);
        if (has_bounds == !model.empty())
            throw core::UsageError(has_bounds ? "MODEL and --bounds exclude each other"
                                              : "MODEL or --bounds is needed");
        if (!has_bounds) return sphere_of_model();
        if (bounds[3] < 0)
            throw core::UsageError(core::text("--bounds: the radius, %g, is below 0", bounds[3]));
        return {{bounds[0], bounds[1], bounds[2]}, bounds[3]};
    }

  private:
    geom::Sphere sphere_of_model() const {
        const core::InputFile file =
            scene::is_url(model) ? scene::open_beginning(model, cache) : core::InputFile(model);
        if (splat::is_model(file.bytes())) {
            const splat::Header header = splat::parse_header(file.bytes(), file.name());
            return {header.origin, header.scale};
        }
        const mesh::Mesh mesh = mesh::read_mesh_bytes(file.bytes(), file.name()).mesh;
        if (mesh.positions.empty()) throw core::Error(file.name() + ": holds no vertex");
        geom::Sphere sphere = mesh.is_cloud() ? geom::sphere_around(mesh.positions)
                                              : geom::sphere_around(mesh.positions, mesh.triangles);
        sphere.centre += mesh.origin;
        return sphere;
    }
};

glm::dvec3 axis_of(const std::string& name) {
    glm::dvec3 up(0);
    up[name.back() - 'x'] = name.starts_with('-') ? -1 : 1;
    return up;
}

void add_frames(CLI::App& app, int64_t& frames, const std::string& help) {
    core::add_integer(app, "--frames", frames, 1, geom::kMostFrames, help);
}

void add_fps(CLI::App& app, double& fps) {
    core::add_number(app, "--fps", fps, 1e-3, 1e6, "", "Frames a second, for the cameras' times");
}

// The options of geom::Shot.
struct ShotOptions {
    int64_t frames = 240;
    double fps = geom::kDefaultFps;
    double fovy_deg = 30;
    std::array<double, 2> resolution{1280, 720};
    std::string up = "y";

    void add_to(CLI::App& app) {
        add_frames(app, frames, "How many cameras");
        add_fps(app, fps);
        core::add_number(app, "--fovy", fovy_deg, 0.001, 179, "degrees", "Vertical field of view");
        core::add_numbers(app, "--resolution", resolution, "W,H",
                          "Size of the picture; its shape counts for what fits");
        app.add_option("--up", up, "The model's axis that points up: x, y, z, -x, -y or -z")
            ->check(core::one_of({"x", "y", "z", "-x", "-y", "-z"}))
            ->type_name("AXIS");
    }

    geom::Shot shot() const {
        for (const double side : resolution)
            if (!(side >= 1 && side <= 65536))
                throw core::UsageError(
                    core::text("--resolution: %g is out of range; it must be from 1 to 65536", side));
        return {int(frames), fps, fovy_deg, resolution[0] / resolution[1], axis_of(up)};
    }
};

// One subcommand: `make` gives its path, and adds what it worked from to the report.
struct Command {
    CLI::App* app;
    std::function<std::vector<geom::Camera>(core::Json& report)> make;
};

void add_azimuth(CLI::App& app, double& azimuth_deg, const std::string& help) {
    core::add_number(app, "--azimuth", azimuth_deg, -360, 360, "degrees", help);
}

void add_elevation(CLI::App& app, double& elevation_deg, const std::string& help) {
    core::add_number(app, "--elevation", elevation_deg, -90, 90, "degrees", help);
}

// All that the command line can say.
struct Arguments {
    std::string output = "-";
    Scene scene;
    ShotOptions shot;
    geom::Orbit orbit;
    geom::Dolly dolly;
    std::array<double, 3> dolly_target{kNotGiven, kNotGiven, kNotGiven};
    double near_factor = kNotGiven;
    geom::Walk walk;
    int64_t laps = walk.laps, lap_turns = walk.turns;
    double walk_distance = kNotGiven;
    std::string keys;
    geom::Spline spline;
    int64_t spline_frames = 0;
    std::string timing = "even";
};

CLI::App& add_subcommand(core::Program& program, Arguments& arguments, const std::string& name,
                         const std::string& description) {
    CLI::App& app = *program.options.add_subcommand(name, description);
    app.add_option("-o,--output", arguments.output, "Path file to write; - for standard output")
        ->type_name("FILE");
    return app;
}

geom::Sphere sphere_for(const Arguments& arguments, core::Json& report) {
    const geom::Sphere sphere = arguments.scene.sphere();
    report["centre"] = {sphere.centre.x, sphere.centre.y, sphere.centre.z};
    report["radius"] = sphere.radius;
    return sphere;
}

Command add_orbit(core::Program& program, Arguments& a) {
    CLI::App& app = add_subcommand(program, a, "orbit", "Round the model, all of it in the frame");
    a.scene.add_to(app);
    core::add_number(app, "--turns", a.orbit.turns, -1000, 1000, "",
                     "Times round; negative for clockwise from above");
    add_azimuth(app, a.orbit.azimuth_deg, "Where to start: 0 at the front, 90 at the model's +X");
    add_elevation(app, a.orbit.elevation_deg, "Height of the eye");
    core::add_number(app, "--distance", a.orbit.distance, kNearest, kFarthest, "",
                     "From the centre; 1 is where the bounds touch the frame");
    a.shot.add_to(app);
    return {&app, [&a](core::Json& report) {
                const geom::Shot shot = a.shot.shot();
                return geom::orbit(sphere_for(a, report), shot, a.orbit);
            }};
}

Command add_dolly(core::Program& program, Arguments& a) {
    CLI::App& app = add_subcommand(program, a, "dolly", "From far to a close-up and back, at an even zoom");
    a.scene.add_to(app);
    core::add_numbers(app, "--target", a.dolly_target, "X,Y,Z", "Point to go to (default the centre)");
    add_azimuth(app, a.dolly.azimuth_deg, "Side to come from: 0 the front, 90 the model's +X");
    add_elevation(app, a.dolly.elevation_deg, "Height of the eye");
    core::add_number(app, "--far-factor", a.dolly.far_factor, kNearest, kFarthest, "",
                     "Farthest distance; 1 is where the bounds touch the frame");
    core::add_number(app, "--near-factor", a.near_factor, kNearest, kFarthest, "",
                     "Nearest distance, in the same unit (default 1.1 radii of the bounds)");
    a.shot.add_to(app);
    return {&app, [&a](core::Json& report) {
                if (!std::isnan(a.dolly_target[0]))
                    a.dolly.target = {a.dolly_target[0], a.dolly_target[1], a.dolly_target[2]};
                a.dolly.near_factor = if_given(a.near_factor);
                if (a.near_factor >= a.dolly.far_factor)
                    throw core::UsageError(core::text("--near-factor: %g is not below %g of --far-factor",
                                                      a.near_factor, a.dolly.far_factor));
                const geom::Shot shot = a.shot.shot();
                return geom::dolly(sphere_for(a, report), shot, a.dolly);
            }};
}

Command add_walk(core::Program& program, Arguments& a) {
    CLI::App& app =
        add_subcommand(program, a, "walk", "A close look from top to bottom and up again, twice the same");
    a.scene.add_to(app);
    core::add_integer(app, "--laps", a.laps, 1, 1000, "How often to do the same; must divide the frames");
    core::add_integer(app, "--turns", a.lap_turns, -1000, 1000, "Times round the model in each lap");
    add_elevation(app, a.walk.elevation_deg, "Height of the eye over its target at the top");
    core::add_number(
        app, "--distance", a.walk_distance, kNearest, kFarthest, "",
        "From the target; 1 is where the bounds would touch the frame (default 0.6, outside the bounds)");
    a.shot.add_to(app);
    return {&app, [&a](core::Json& report) {
                a.walk.laps = int(a.laps);
                a.walk.turns = int(a.lap_turns);
                a.walk.distance = if_given(a.walk_distance);
                if (a.shot.frames % a.laps != 0)
                    throw core::UsageError(core::text("--frames: %d cannot be parted into %d equal laps",
                                                      int(a.shot.frames), a.walk.laps));
                const geom::Shot shot = a.shot.shot();
                return geom::walk(sphere_for(a, report), shot, a.walk);
            }};
}

Command add_spline(core::Program& program, Arguments& a) {
    CLI::App& app = add_subcommand(program, a, "spline", "A smooth path through the cameras of a path file");
    app.add_option("KEYS", a.keys, "Path file with the key cameras; - for standard input")->required();
    CLI::Option* frames = core::add_integer(app, "--frames", a.spline_frames, 1, geom::kMostFrames,
                                            "How many cameras (default: a second from each key to the next)")
                              ->default_str("");
    add_fps(app, a.spline.fps);
    app.add_option("--timing", a.timing, "even: the same time from key to key; keys: as the keys' \"t\" say")
        ->check(core::one_of({"even", "keys"}))
        ->type_name("HOW");
    app.add_flag("--closed", a.spline.closed, "Go back from the last key to the first");
    return {&app, [&a, frames](core::Json& report) {
                const bool by_keys = a.timing == "keys";
                if (by_keys && (frames->count() > 0 || a.spline.closed))
                    throw core::UsageError(std::string(a.spline.closed ? "--closed" : "--frames") +
                                           ": not with --timing keys");
                a.spline.timing = by_keys ? geom::Spline::Timing::keys : geom::Spline::Timing::even;
                a.spline.frames = int(a.spline_frames);
                const core::InputFile file(a.keys);
                const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()),
                                            file.bytes().size());
                const std::vector<geom::Camera> keys = geom::parse_path(text, file.name());
                report["keys"] = keys.size();
                try {
                    return geom::spline(keys, a.spline);
                } catch (const core::Error& error) {
                    throw core::Error(file.name() + ": " + error.what());
                }
            }};
}

void make_path(const Command& command, const Arguments& arguments) {
    for (const std::string& input : {arguments.scene.model, arguments.keys})
        if (core::same_file(input, arguments.output))
            throw core::UsageError(arguments.output + ": is input and output");
    core::Report report({arguments.scene.model, arguments.keys}, {arguments.output});
    core::Json line{{"path", command.app->get_name()}};
    const std::vector<geom::Camera> path = command.make(line);
    core::OutputFile output(arguments.output);
    output.write(geom::format_path(path));
    output.commit();
    line["frames"] = path.size();
    line["last_t_s"] = path.back().time_s;
    report.write(line);
    report.commit();
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("qs-path", "Make a camera path, one camera a line as in camera-path(5).",
                          QS_VERSION);
    program.options.require_subcommand(1);
    Arguments arguments;
    const Command commands[] = {add_orbit(program, arguments), add_dolly(program, arguments),
                                add_walk(program, arguments), add_spline(program, arguments)};
    return program.run(argc, argv, [&] {
        for (const Command& command : commands)
            if (command.app->parsed()) make_path(command, arguments);
    });
}
