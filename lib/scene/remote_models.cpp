#include "scene/remote_models.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "core/error.h"
#include "core/json.h"
#include "fetch/client.h"
#include "fetch/private_folder.h"
#include "splat/format.h"

namespace scene {

namespace {

constexpr double kOpenTimeout_s = 60;

// Beside this program, where both are built or installed; else where the system looks.
std::string fetch_program() {
    std::array<char, 4096> path = {};
    const ssize_t size = ::readlink("/proc/self/exe", path.data(), path.size() - 1);
    std::string program = size > 0 ? path.data() : "";
    program = program.substr(0, program.rfind('/') + 1) + "qs-fetch";
    return ::access(program.c_str(), X_OK) == 0 ? program : "qs-fetch";
}

fetch::ClientOptions client_options(const std::string& cache) {
    return {.folder = cache.empty() ? fetch::default_folder() : cache,
            .program = fetch_program(),
            .daemon_arguments = {}};
}

bool is_there(const fetch::RemoteFile& file, uint64_t offset, uint64_t size) {
    const auto first = uint32_t(offset / file.block_bytes()),
               last = uint32_t((offset + size - 1) / file.block_bytes());
    for (uint32_t block = first; block <= last; ++block)
        if (file.block(block).empty()) return false;
    return true;
}

class RemoteSource final : public splat::BlockSource {
  public:
    RemoteSource(std::string url, const fetch::RemoteFile& file)
        : url_(std::move(url)), file_(file), data_(file.block(0).data()) {}
    std::string name() const override { return url_; }
    uint64_t file_bytes() const override { return file_.bytes(); }
    const std::byte* data() const override { return data_; }
    bool has(uint64_t offset, uint64_t size) const override {
        return size == 0 || is_there(file_, offset, size);
    }

  private:
    std::string url_;
    const fetch::RemoteFile& file_;
    const std::byte* data_;  // blocks stand behind each other
};

}  // namespace

struct RemoteModels::State {
    explicit State(const std::string& cache) : connection(client_options(cache)) {}

    struct File {
        std::unique_ptr<fetch::RemoteFile> file;
        bool is_told_replaced = false, is_asked = false;
        std::string told_trouble;
    };
    struct Place {
        File* file = nullptr;
        uint64_t first_block_offset = 0;
        uint32_t block_bytes = 0;
    };

    fetch::Connection connection;
    std::map<std::string, File> files;  // by URL
    std::vector<Place> places;          // by model
    Counters before;

    // Of all the daemon has done; only where it serves no others are these this program's.
    Counters daemon_counters() {
        const core::Json status = core::Json::parse(connection.status());
        Counters c{status.value("body_bytes", uint64_t(0)), status.value("requests", uint64_t(0))};
        for (const core::Json& server : status.value("servers", core::Json::array())) {
            c.round_trip_s = std::max(c.round_trip_s, server.value("round_trip_ms", 0.0) / 1000);
            c.bytes_per_s = std::max(c.bytes_per_s, server.value("bytes_per_s", 0.0));
        }
        return c;
    }
};

RemoteModels::RemoteModels(const std::string& cache) : state_(std::make_unique<State>(cache)) {
    state_->before = state_->daemon_counters();
}
RemoteModels::~RemoteModels() = default;

std::unique_ptr<const splat::BlockSource> RemoteModels::open(const std::string& url) {
    State::File& known = state_->files[url];
    if (!known.file) known.file = state_->connection.open(url, kOpenTimeout_s);
    bring(url, splat::kBlocksAt);
    return std::make_unique<RemoteSource>(url, *known.file);
}

void RemoteModels::bring(const std::string& url, uint64_t bytes) {
    fetch::RemoteFile& file = *state_->files.at(url).file;
    bytes = std::min(bytes, file.bytes());
    std::vector<fetch::Want> wants;
    const uint64_t wanted = std::min(std::max(bytes, kFirstPictureBytes), file.bytes());
    for (uint32_t block = 0; uint64_t{block} * file.block_bytes() < wanted; ++block)
        wants.push_back({block, 1});
    file.want(wants);
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(kOpenTimeout_s);
    while (!is_there(file, 0, bytes)) {
        if (!file.failure().empty()) throw core::Error(url + ": " + file.failure());
        if (std::chrono::steady_clock::now() > until)
            throw core::Error(
                url + (file.trouble().empty() ? ": the server does not answer" : ": " + file.trouble()));
        if (state_->connection.wait(1)) file.want(wants);
    }
}

void RemoteModels::place(const std::string& url, size_t model, uint64_t first_block_offset,
                         uint32_t block_bytes) {
    if (state_->places.size() <= model) state_->places.resize(model + 1);
    state_->places[model] = {&state_->files.at(url), first_block_offset, block_bytes};
}

void RemoteModels::ask(std::span<const BlockRequest> requests) {
    std::map<State::File*, std::vector<fetch::Want>> wants;
    for (const BlockRequest& request : requests) {
        const State::Place& place = state_->places[request.model];
        const uint64_t offset = place.first_block_offset + request.block * place.block_bytes;
        const fetch::RemoteFile& file = *place.file->file;
        const uint64_t last = (offset + place.block_bytes - 1) / file.block_bytes();
        for (uint64_t block = offset / file.block_bytes(); block <= last; ++block)
            wants[place.file].push_back({uint32_t(block), request.priority});
    }
    for (auto& [url, file] : state_->files) {
        const auto found = wants.find(&file);
        const bool is_asked = found != wants.end();
        if (is_asked || file.is_asked)
            file.file->want(is_asked ? std::move(found->second) : std::vector<fetch::Want>());
        file.is_asked = is_asked;
    }
}

bool RemoteModels::wait(double timeout_s) {
    const bool has_come = state_->connection.wait(timeout_s);
    for (const auto& [url, file] : state_->files)
        if (file.is_asked && !file.file->failure().empty() && !file.file->is_replaced())
            throw core::Error(url + ": " + file.file->failure());
    return has_come;
}

bool RemoteModels::has_ended() const {
    return std::any_of(state_->files.begin(), state_->files.end(),
                       [](const auto& file) { return file.second.file->is_replaced(); });
}

BlockFetcher::Counters RemoteModels::counters() {
    Counters now = state_->daemon_counters();
    now.bytes -= std::min(now.bytes, state_->before.bytes);
    now.requests -= std::min(now.requests, state_->before.requests);
    return now;
}

std::vector<std::string> RemoteModels::news() {
    std::vector<std::string> lines;
    for (auto& [url, file] : state_->files) {
        if (file.file->is_replaced() && !file.is_told_replaced) {
            file.is_told_replaced = true;
            lines.push_back(
                url +
                ": was replaced at the server while it was drawn; what is drawn is of the version "
                "before, as far as it had arrived; draw it again for the new one");
        }
        if (!file.file->trouble().empty() && file.file->trouble() != file.told_trouble)
            lines.push_back(url + ": " + file.file->trouble() + "; it is being tried again");
        file.told_trouble = file.file->trouble();
    }
    return lines;
}

}  // namespace scene
