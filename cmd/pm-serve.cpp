// pm-serve: serve progressive meshes to clients that refine them by what they see.  The work is pm::Server.
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "net/stop_signals.h"
#include "pm/client.h"
#include "pm/server.h"

namespace {

struct Arguments {
    std::vector<std::string> models;
    std::string listen = "127.0.0.1:4100", status;
    bool uses_stdio = false;
    int64_t clients = 1000, packet = 512;
    double idle_ms = 0, stall_ms = 30'000;
    pm::ServerOptions server;
};

// NAME=FILE, or a file that is known by its name without ".pm".
pm::CatalogueEntry parse_entry(const std::string& word) {
    const size_t equals = word.find('=');
    if (equals != word.npos && equals > 0) return {word.substr(0, equals), word.substr(equals + 1)};
    return {std::filesystem::path(word).stem().string(), word};
}

void print_status(const Arguments& a) {
    constexpr double kTimeoutSeconds = 10;
    const net::Address address = net::parse_address(a.status);
    pm::Client client(
        net::FrameStream(net::connect_to(address, kTimeoutSeconds), a.status, pm::kMostServerMessageBytes),
        kTimeoutSeconds);
    core::print(client.status() + "\n");
}

void serve(Arguments& a) {
    a.server.limits.most_connections = size_t(a.clients);
    a.server.limits.connection.stall_s = a.stall_ms / 1000;
    a.server.limits.connection.idle_s = a.idle_ms / 1000;
    a.server.packet_decisions = uint32_t(a.packet);
    std::vector<pm::CatalogueEntry> catalogue;
    for (const std::string& word : a.models) catalogue.push_back(parse_entry(word));
    net::EventLoop loop;
    net::StopSignals stop(loop);
    core::Report report(a.models, {});
    pm::Server server(loop, catalogue, a.server);
    if (a.uses_stdio) {
        server.serve_one(core::Descriptor(::dup(STDIN_FILENO)), core::Descriptor(::dup(STDOUT_FILENO)));
    } else {
        core::Descriptor inherited = net::inherited_socket(SOCK_STREAM);
        net::Listener listener =
            inherited ? net::Listener(std::move(inherited)) : net::Listener(net::parse_address(a.listen));
        core::write_standard_output("listening on " + listener.name() + "\n", true);
        server.listen(std::move(listener));
    }
    loop.run();
    report.write(server.status());
    report.commit();
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program(
        "pm-serve", "Serve progressive meshes to clients that refine them by what they see.", QS_VERSION);
    Arguments a;
    program.options.add_option("MODEL", a.models,
                               "Progressive meshes; a client asks for NAME of NAME=FILE, or of NAME.pm");
    auto* listen = program.options.add_option(
        "--listen", a.listen, "HOST:PORT, port 0 for a free one, or the path of a Unix socket");
    listen->type_name("ADDRESS")->capture_default_str();
    program.options.add_flag("--stdio", a.uses_stdio, "Serve one client on standard input and output")
        ->excludes(listen);
    program.options.add_option("--status", a.status, "Print the counters of the server there, as JSON")
        ->type_name("ADDRESS");
    program.add_integer("--clients", a.clients, 1, 100'000, "To serve at a time");
    program.add_duration("--idle", a.idle_ms, 0, 86'400'000,
                         "Drop a client that says nothing for so long; 0: never");
    program.add_duration("--stall", a.stall_ms, 100, 3'600'000,
                         "Drop a client that does not read, or stops within a message, for so long");
    program.add_size("--queue", a.server.limits.connection.most_queued_bytes,
                     "Unsent for a client, beyond which it is not read from");
    program.add_integer("--packet", a.packet, 1, pm::kMostDecisions,
                        "Splits of a packet, after which a newer view is answered");
    return program.run(argc, argv, [&] {
        if (!a.status.empty()) {
            if (!a.models.empty()) throw core::UsageError("--status: asks a server, and serves no models");
            return print_status(a);
        }
        if (a.models.empty()) throw core::UsageError("MODEL: none is given to be served");
        serve(a);
    });
}
