// ppve-sample: answer requests for frusta with depth images.  The work is scene::open_sampler() and
// ppve::Server.
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <map>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "core/words.h"
#include "net/stop_signals.h"
#include "ppve/server.h"
#include "ppve/status.h"
#include "scene/samplers.h"

namespace {

const std::map<std::string, scene::SamplerKind> kSamplers = {{"raster", scene::SamplerKind::raster},
                                                             {"egl", scene::SamplerKind::egl},
                                                             {"osmesa", scene::SamplerKind::osmesa},
                                                             {"embree", scene::SamplerKind::embree}};

struct Arguments {
    std::vector<std::string> meshes;
    scene::SamplerOptions sampler;
    std::string listen, status, write_clusters;
    int64_t clients = 16, most_pixels = 1 << 25;
    uint64_t memory = uint64_t(1) << 30;
    double stall_ms = 30'000, idle_ms = 0;
};

core::Json report_of(const ppve::AnswerReport& r) {
    const auto& s = r.sampling;
    const auto& e = r.elimination;
    return {{"request", r.id},
            {"samples", e.samples},
            {"samples_kept", e.kept},
            {"samples_lost", e.lost},
            {"points_replaced", e.removed},
            {"leaves_deleted", r.deleted},
            {"leaves_evicted", r.evicted},
            {"starts_anew", r.starts_anew},
            {"mantissa_bits", r.mantissa_bits},
            {"depth_bound_px", r.bound_px},
            {"clusters", s.clusters},
            {"clusters_touched", s.clusters_touched},
            {"clusters_hidden", s.clusters_hidden},
            {"bytes", s.bytes},
            {"bytes_touched", s.bytes_touched},
            {"triangles_tested", s.triangles_tested},
            {"triangles_drawn", s.triangles_drawn},
            {"image_bytes", r.image_bytes},
            {"message_bytes", r.message_bytes},
            {"tree_points", r.tree_points},
            {"tree_clusters", r.tree_clusters},
            {"tree_bytes", r.tree_bytes},
            {"ms",
             {{"sample", r.sample_ms},
              {"eliminate", r.eliminate_ms},
              {"encode", r.encode_ms},
              {"insert", r.insert_ms},
              {"total", r.total_ms}}}};
}

ppve::ServerOptions options_of(const Arguments& a) {
    ppve::ServerOptions options;
    const size_t slash = a.meshes.front().rfind('/');
    options.scene = a.meshes.front() == "-"
                        ? "standard input"
                        : a.meshes.front().substr(slash == std::string::npos ? 0 : slash + 1);
    options.session = {uint64_t(a.most_pixels), a.memory / ppve::kPointBytes};
    options.server.most_connections = size_t(a.clients);
    options.server.connection.most_frame_bytes = ppve::kMostRequestBytes;
    options.server.connection.stall_s = a.stall_ms / 1000;
    options.server.connection.idle_s = a.idle_ms / 1000;
    return options;
}

void listen(const std::string& address, net::Server& server) {
    net::allow_many_descriptors();
    core::Descriptor inherited = net::inherited_socket(SOCK_STREAM);
    net::Listener listener =
        inherited ? net::Listener(std::move(inherited)) : net::Listener(net::parse_address(address));
    core::notice("listening on " + listener.name());
    server.listen(std::move(listener));
}

void serve(const Arguments& a, core::Report& report) {
    const std::unique_ptr<ppve::Sampler> sampler = scene::open_sampler(a.meshes, a.sampler);
    ::signal(SIGPIPE, SIG_IGN);
    net::EventLoop loop;
    const net::StopSignals stop(loop);
    ppve::Server server(loop, *sampler, options_of(a),
                        [&](const ppve::AnswerReport& r) { report.write(report_of(r)); });
    if (a.listen.empty())
        server.connections().serve_one(core::Descriptor(::dup(STDIN_FILENO)),
                                       core::Descriptor(::dup(STDOUT_FILENO)));
    else
        listen(a.listen, server.connections());
    loop.run();
}

void add_options(core::Program& program, Arguments& a) {
    program.options.add_option(
        "MESH", a.meshes, "What is sampled: all that qs-build reads, .qs models, a .mhd volume, clusters");
    program.options
        .add_option_function<std::string>(
            "--sampler", [&](const std::string& name) { a.sampler.kind = kSamplers.at(name); },
            "raster, egl, osmesa or embree")
        ->check(core::one_of({"raster", "egl", "osmesa", "embree"}))
        ->type_name("NAME")
        ->default_str("raster");
    program.add_number("--iso", a.sampler.iso, -1e30, 1e30, "value", "Of a volume: value of the surface");
    program.options
        .add_option("--listen", a.listen,
                    "Serve clients at HOST:PORT or a Unix socket, not on standard input and output")
        ->type_name("ADDRESS");
    program.options.add_option("--status", a.status, "Print the counters of the server there, as JSON")
        ->type_name("ADDRESS");
    program.options
        .add_option("--write-clusters", a.write_clusters,
                    "Write the mesh as it is kept, to be mapped later, and end")
        ->type_name("FILE");
    program.add_integer("--clients", a.clients, 1, 10'000, "To serve at a time");
    program.add_size("--memory", a.memory, "For the record of what a client has, each");
    program.add_integer("--most-pixels", a.most_pixels, 1, int64_t(ppve::kMostSide) * ppve::kMostSide,
                        "Of a request");
    program.add_duration("--stall", a.stall_ms, 100, 3'600'000,
                         "Drop a client that takes nothing for so long");
    program.add_duration("--idle", a.idle_ms, 0, 86'400'000,
                         "Drop a client that says nothing for so long; 0 for never");
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program("ppve-sample", "Sample a mesh or a volume for clients that draw it as points.",
                          QS_VERSION);
    Arguments arguments;
    add_options(program, arguments);
    return program.run(argc, argv, [&] {
        const Arguments& a = arguments;
        if (!a.status.empty()) {
            if (!a.meshes.empty() || !a.listen.empty() || !a.write_clusters.empty())
                throw core::UsageError("--status: asks a server, and neither samples nor listens");
            constexpr double kTimeoutSeconds = 10;
            return core::print(ppve::ask_status(a.status, kTimeoutSeconds) + "\n");
        }
        if (a.meshes.empty()) throw core::UsageError("MESH: none is given to be sampled");
        core::Report report(a.meshes, {a.write_clusters});
        if (!a.write_clusters.empty()) {
            if (!a.listen.empty()) throw core::UsageError("--write-clusters: not with --listen");
            const uint64_t bytes = scene::write_clusters(a.meshes, a.write_clusters);
            report.write({{"bytes", bytes}});
        } else {
            if (a.listen.empty()) core::refuse_binary_to_terminal(false);
            serve(a, report);
        }
        report.commit();
    });
}
