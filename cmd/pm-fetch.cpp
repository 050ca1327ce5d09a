// pm-fetch: follow a camera path through a progressive mesh at a server.  The work is pm::Follower.
#include <array>
#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "geom/camera.h"
#include "mesh/mesh.h"
#include "pm/client_mesh.h"
#include "pm/follow.h"

namespace {

struct Arguments {
    std::string location, path, output, state, resume;
    std::array<double, 2> resolution = {1280, 720};
    int64_t frame = -1, retries = 5;
    double timeout_ms = 60'000;
    bool fetches_all = false, lists = false, is_one_way = false, sends_lists = false;
    pm::FollowOptions follow;
};

std::vector<geom::Camera> cameras_of(const Arguments& a) {
    if (a.fetches_all) return {geom::Camera()};
    const core::InputFile file(a.path);
    return geom::parse_path({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()},
                            file.name());
}

std::unique_ptr<pm::ClientState> earlier_state(const Arguments& a) {
    if (a.resume.empty()) return nullptr;
    const core::InputFile file(a.resume);
    return std::make_unique<pm::ClientState>(pm::ClientState::from_bytes(file.bytes(), file.name()));
}

void write_mesh(const std::string& output, pm::Follower& follower) {
    core::OutputFile out(output);
    const std::string ply = mesh::to_ply(pm::mesh_of(follower.state().replica(), follower.front()));
    out.write(ply);
    out.commit();
}

void fetch(const Arguments& a, const pm::Location& location) {
    const std::vector<geom::Camera> cameras = cameras_of(a);
    const int wanted_frame = a.frame < 0 ? int(cameras.size()) - 1 : int(a.frame);
    if (a.frame >= int64_t(cameras.size()))
        throw core::UsageError(
            core::text("--frame: %d is beyond the path's %zu frames", wanted_frame, cameras.size()));
    core::Report report({a.path, a.resume}, {a.output, a.state});
    auto state = earlier_state(a);
    if (state && state->service() != a.follow.service)
        throw core::UsageError("--resume: give --one-way or --lists where the state was kept with it");
    pm::Follower follower(pm::connector(location.address, a.follow.timeout_s), location.name, a.follow,
                          std::move(state));
    core::Progress progress("frame", cameras.size());
    for (size_t i = 0; i != cameras.size(); ++i) {
        std::optional<double> next_time_s;
        if (i + 1 != cameras.size()) next_time_s = cameras[i + 1].time_s;
        const pm::FrameCosts costs = follower.show(int(i), cameras[i], next_time_s);
        report.write(pm::to_json(costs));
        if (int(i) == wanted_frame && !a.output.empty()) write_mesh(a.output, follower);
        progress.update(i + 1);
    }
    core::notice(core::text("%u splits, %llu bytes up, %llu bytes down",
                            follower.state().replica().split_count(),
                            static_cast<unsigned long long>(follower.bytes_up()),
                            static_cast<unsigned long long>(follower.bytes_down())));
    if (!a.state.empty()) {
        core::OutputFile out(a.state);
        out.write(follower.state().to_bytes());
        out.commit();
    }
    report.commit();
}

void run(Arguments& a) {
    const pm::Location location = pm::parse_location(a.location);
    a.follow.timeout_s = a.timeout_ms / 1000;
    if (a.lists) {
        pm::Client client(pm::connector(location.address, a.follow.timeout_s)(), a.follow.timeout_s);
        return core::print(client.catalogue() + "\n");
    }
    if (a.path.empty() == !a.fetches_all) throw core::UsageError("--path: give a camera path, or --all");
    for (const double side : a.resolution)
        if (!(side >= 1 && side <= 65536 && side == double(int(side))))
            throw core::UsageError("--resolution: sides are whole numbers of pixels, from 1 to 65536");
    a.follow.width = int(a.resolution[0]), a.follow.height = int(a.resolution[1]);
    a.follow.most_retries = int(a.retries);
    if (a.is_one_way) a.follow.service = pm::Service::one_way;
    if (a.sends_lists) a.follow.service = pm::Service::lists;
    if (a.fetches_all) a.follow.culling = pm::Culling::off, a.follow.threshold_px = 0;
    if (a.output == "-") core::refuse_binary_to_terminal(true);
    fetch(a, location);
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("pm-fetch", "Follow a camera path through a progressive mesh at a server.",
                          QS_VERSION);
    Arguments a;
    program.options.add_option("SOURCE", a.location, "pm://HOST:PORT/NAME, or pm:///PATH/OF/SOCKET/NAME")
        ->required();
    program.options.add_option("--path", a.path, "Camera path to follow; - is standard input")
        ->type_name("FILE");
    program.options.add_flag("--all", a.fetches_all, "Fetch the whole model instead");
    program.options.add_flag("--list", a.lists, "Print what the server has, as JSON");
    auto* one_way = program.options.add_flag("--one-way", a.is_one_way,
                                             "Never coarsen: splits come without their bounds");
    program.options.add_flag("--lists", a.sends_lists, "Say what to split, and not what is looked at")
        ->excludes(one_way);
    program.add_numbers("--resolution", a.resolution, "W,H", "Pixels of the pictures that the mesh is for");
    program.add_number("--threshold", a.follow.threshold_px, 0, 1e6, "pixels",
                       "Refine where the error is larger");
    program.options.add_flag("--realtime", a.follow.in_real_time,
                             "Send views at the path's times, complete or not");
    program.options
        .add_option("-o,--output", a.output, "PLY to write, the mesh of a frame; - is standard output")
        ->type_name("FILE");
    program.add_integer("--frame", a.frame, 0, 1'000'000'000, "Which frame's, from 0")
        ->default_str("the last");
    program.options.add_option("--state", a.state, "Keep what was received, for --resume")->type_name("FILE");
    program.options.add_option("--resume", a.resume, "Go on from what --state kept")->type_name("FILE");
    program.add_duration("--timeout", a.timeout_ms, 1, 86'400'000,
                         "Give up when nothing has come for so long");
    program.add_integer("--retries", a.retries, 0, 1000, "Lost connections in a row until it is given up");
    return program.run(argc, argv, [&] { run(a); });
}
