// qs-fetch: a cache of files at HTTP servers, shared by the programs on a machine.  The work is
// fetch::Daemon, and fetch::Connection for the verbs that talk to one; what a level is, splat::level_prefix()
// knows.
#include <unistd.h>

#include <array>
#include <charconv>
#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "fetch/daemon.h"
#include "fetch/private_folder.h"
#include "fetch/read_range.h"
#include "splat/level_prefix.h"

namespace {

struct Arguments {
    std::string folder;
    fetch::DaemonOptions daemon;
    int64_t clients = 4096, connections = 6, retries = 5;
    double rate = 0, delay_ms = 0, stall_ms = 10'000, idle_ms = 0, max_age_ms = 600'000;
    std::string url, range, output, headers;
    double timeout_ms = 60'000;
    uint64_t prefetch_bytes = 0, keep_bytes = 0;
    int64_t prefetch_levels = 0;
    bool json = false;
};

// What runs now, for the daemon that a verb starts.
std::string own_program() {
    std::array<char, 4096> path = {};
    const ssize_t size = ::readlink("/proc/self/exe", path.data(), path.size() - 1);
    return size > 0 ? path.data() : "qs-fetch";
}

enum class Start { if_needed, never };

fetch::Connection connect(const Arguments& a, Start start) {
    return fetch::Connection({.folder = a.folder,
                              .program = start == Start::if_needed ? own_program() : "",
                              .daemon_arguments = {}});
}

void serve(Arguments& a) {
    constexpr uint64_t kLeast = uint64_t{1} << 20;
    if (a.daemon.limit_bytes < kLeast)
        throw core::UsageError("--limit: less than 1M holds no picture's blocks; it must be at least 1M");
    a.daemon.folder = a.folder;
    a.daemon.most_clients = size_t(a.clients);
    a.daemon.downloads = {.most_retries = unsigned(a.retries), .max_age_s = a.max_age_ms / 1000};
    a.daemon.idle_exit_s = a.idle_ms / 1000;
    a.daemon.transport.connections = unsigned(a.connections);
    a.daemon.transport.bytes_per_s = a.rate / 8;
    a.daemon.transport.round_trip_s = a.delay_ms / 1000;
    a.daemon.transport.stall_s = a.stall_ms / 1000;
    if (a.headers.empty()) a.headers = fetch::default_header_rules();
    if (!a.headers.empty()) a.daemon.transport.header_rules = fetch::HeaderRules(a.headers);
    a.daemon.transport.user_agent = std::string("qs-fetch/") + QS_VERSION;
    fetch::Daemon daemon(a.daemon);
    core::notice("listening in " + a.folder);
    daemon.run();
}

struct ByteRange {
    uint64_t first, last;
};

// "A-B" and "A-", bytes, both included.
ByteRange parse_range(const std::string& text, uint64_t file_bytes) {
    ByteRange range{0, file_bytes - 1};
    const char *at = text.data(), *const end = at + text.size();
    const auto first = std::from_chars(at, end, range.first);
    bool is_right = first.ec == std::errc() && first.ptr != end && *first.ptr == '-';
    if (is_right && first.ptr + 1 != end) {
        const auto last = std::from_chars(first.ptr + 1, end, range.last);
        is_right = last.ec == std::errc() && last.ptr == end;
    }
    if (!is_right || range.first > range.last)
        throw core::UsageError("--range: '" + text +
                               "' is not a range of bytes; give first and last, as in 0-4095");
    if (range.first >= file_bytes)
        throw core::Error(core::text("--range: %s begins beyond the file's %llu bytes", text.c_str(),
                                     static_cast<unsigned long long>(file_bytes)));
    range.last = std::min(range.last, file_bytes - 1);
    return range;
}

std::unique_ptr<fetch::RemoteFile> open(fetch::Connection& connection, const Arguments& a) {
    auto file = connection.open(a.url, a.timeout_ms / 1000);
    if (!file->note().empty()) core::warn(a.url + ": " + file->note());
    return file;
}

void get(const Arguments& a) {
    if (!a.range.empty()) parse_range(a.range, UINT64_MAX);
    core::refuse_binary_to_terminal(!a.output.empty());
    const std::string output = a.output.empty() ? "-" : a.output;
    core::Report report({}, {output});
    fetch::Connection connection = connect(a, Start::if_needed);
    const auto file = open(connection, a);
    const ByteRange range =
        a.range.empty() ? ByteRange{0, file->bytes() - 1} : parse_range(a.range, file->bytes());
    core::OutputFile out(output);
    core::Progress progress("fetching", range.last - range.first + 1);
    uint64_t done = 0;
    fetch::read_range(connection, *file, a.url, range.first, range.last, a.timeout_ms / 1000,
                      [&](std::span<const std::byte> bytes) {
                          out.write(bytes);
                          progress.update(done += bytes.size());
                      });
    out.commit();
    report.write({{"url", a.url}, {"file_bytes", file->bytes()}, {"bytes", done}});
    report.commit();
}

// Bytes from the beginning on that hold the first levels of a model.
uint64_t bytes_of_levels(fetch::Connection& connection, fetch::RemoteFile& file, const Arguments& a) {
    uint64_t bytes = 13 * 1024;  // what comes with the opening
    std::vector<std::byte> prefix;
    for (;;) {
        bytes = std::min(bytes, file.bytes());
        fetch::read_range(
            connection, file, a.url, prefix.size(), bytes - 1, a.timeout_ms / 1000,
            [&](std::span<const std::byte> got) { prefix.insert(prefix.end(), got.begin(), got.end()); });
        core::OutputFile copy(core::OutputFile::InMemory{a.url});
        copy.write(prefix);
        const splat::Model model(copy.read_back());
        const splat::LevelPrefix levels = splat::level_prefix(model, uint32_t(a.prefetch_levels));
        if (levels.is_known || prefix.size() == file.bytes()) return std::min(levels.bytes, file.bytes());
        bytes = levels.bytes;
    }
}

void prefetch(const Arguments& a) {
    if (a.prefetch_bytes == 0 && a.prefetch_levels == 0)
        throw core::UsageError("prefetch: give --bytes or --levels");
    core::Report report({}, {});
    fetch::Connection connection = connect(a, Start::if_needed);
    const auto file = open(connection, a);
    const uint64_t asked = a.prefetch_levels > 0 ? bytes_of_levels(connection, *file, a) : a.prefetch_bytes;
    const uint64_t bytes = std::min(asked, file->bytes());
    core::Progress progress("fetching", bytes);
    uint64_t done = 0;
    if (bytes > 0)
        fetch::read_range(connection, *file, a.url, 0, bytes - 1, a.timeout_ms / 1000,
                          [&](std::span<const std::byte> got) { progress.update(done += got.size()); });
    report.write({{"url", a.url}, {"file_bytes", file->bytes()}, {"bytes", bytes}});
    report.commit();
}

void status(const Arguments& a) {
    fetch::Connection connection = connect(a, Start::never);
    const std::string text = connection.status();
    if (a.json) {
        core::print(text + "\n");
        return;
    }
    const core::Json json = core::Json::parse(text);
    for (const auto& [key, value] : json.items())
        if (!value.is_array())
            core::print(key + " " + (value.is_string() ? value.get<std::string>() : value.dump()) + "\n");
}

void evict(const Arguments& a) {
    if (!a.url.empty() && a.keep_bytes > 0) throw core::UsageError("--keep: not with a URL");
    fetch::Connection connection = connect(a, Start::if_needed);
    const std::string text = connection.evict(a.keep_bytes, a.url);
    core::Report report({}, {});
    report.write(core::Json::parse(text));
    report.commit();
}

void add_url(CLI::App& app, Arguments& a) {
    app.add_option("URL", a.url, "File at a server, http:// or https://")->required();
}

void add_timeout(CLI::App& app, Arguments& a) {
    core::add_duration(app, "--timeout", a.timeout_ms, 1, 86'400'000,
                       "Give up when nothing has come for so long");
}

CLI::App& add_serve(core::Program& program, Arguments& a) {
    CLI::App& app = *program.options.add_subcommand("serve", "Run the daemon in the foreground");
    core::add_size(app, "--limit", a.daemon.limit_bytes, "Disk space to use at most");
    core::add_integer(app, "--connections", a.connections, 1, 64,
                      "To a server at a time, where it does not speak HTTP/2");
    core::add_integer(app, "--retries", a.retries, 0, 1000, "Failures in a row until a file is given up");
    core::add_duration(app, "--stall", a.stall_ms, 1000, 3'600'000,
                       "Give up a request that gets nothing for so long");
    app.add_option("--cacert", a.daemon.transport.ca_file, "Certificates to trust instead of the system's")
        ->type_name("FILE");
    app.add_option("--headers", a.headers, "Header fields to be let in (default ~/.config/qs-fetch/headers)")
        ->type_name("FILE");
    core::add_duration(app, "--max-age", a.max_age_ms, 0, 365.0 * 86'400'000,
                       "Ask at opening whether a file has changed when nothing came for so long");
    core::add_integer(app, "--clients", a.clients, 1, 100'000, "To serve at a time");
    core::add_duration(app, "--idle-exit", a.idle_ms, 0, 86'400'000,
                       "End when there was no client for so long; 0 for never");
    core::add_rate(app, "--limit-rate", a.rate, "Try out a slow link: bits a second, as in 384k or 8M");
    core::add_duration(app, "--delay", a.delay_ms, 0, 60'000, "Try out a long way: its round trip");
    return app;
}

struct Command {
    CLI::App* app;
    std::function<void()> run;
};

std::vector<Command> add_commands(core::Program& program, Arguments& a) {
    std::vector<Command> commands;
    const auto add = [&](CLI::App& app, std::function<void()> run) {
        commands.push_back({&app, std::move(run)});
    };
    add(add_serve(program, a), [&] { serve(a); });

    CLI::App& getting = *program.options.add_subcommand("get", "Write a file, or a range of its bytes");
    add_url(getting, a);
    getting.add_option("-o,--output", a.output, "Where to write; - is standard output")->type_name("FILE");
    getting.add_option("--range", a.range, "First and last byte, as in 0-4095, or 4096- for all from there")
        ->type_name("A-B");
    add_timeout(getting, a);
    add(getting, [&] { get(a); });

    CLI::App& prefetching =
        *program.options.add_subcommand("prefetch", "Bring the beginning of a file into the cache");
    add_url(prefetching, a);
    auto* const bytes =
        core::add_size(prefetching, "--bytes", a.prefetch_bytes, "How much of it")->default_str("");
    core::add_integer(prefetching, "--levels", a.prefetch_levels, 1, splat::kMaxLevels,
                      "Of a model: its first levels")
        ->default_str("")
        ->excludes(bytes);
    add_timeout(prefetching, a);
    add(prefetching, [&] { prefetch(a); });

    CLI::App& telling = *program.options.add_subcommand("status", "Say what the daemon does and holds");
    telling.add_flag("--json", a.json, "Print JSON, keys as in qs-fetch(1)");
    add(telling, [&] { status(a); });

    CLI::App& evicting =
        *program.options.add_subcommand("evict", "Free disk space: of a URL, or of all that is not in use");
    evicting.add_option("URL", a.url, "The one file to let go");
    core::add_size(evicting, "--keep", a.keep_bytes, "Leave so much of what was used last");
    add(evicting, [&] { evict(a); });

    add(*program.options.add_subcommand("stop", "End the daemon"), [&] { connect(a, Start::never).stop(); });
    return commands;
}

}  // namespace

int main(int argc, char** argv) {
    core::Program program(
        "qs-fetch", "Fetch ranges of files over HTTP, through a cache that all programs share.", QS_VERSION);
    Arguments arguments;
    program.options.require_subcommand(0, 1);
    program.options
        .add_option("--cache", arguments.folder, "Folder of the cache (default ~/.cache/qs-fetch)")
        ->type_name("DIR");
    const std::vector<Command> commands = add_commands(program, arguments);
    return program.run(argc, argv, [&] {
        if (arguments.folder.empty()) arguments.folder = fetch::default_folder();
        for (const Command& command : commands)
            if (command.app->parsed()) return command.run();
        serve(arguments);
    });
}
