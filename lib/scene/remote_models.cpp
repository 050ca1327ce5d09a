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

// The blocks of a file that hold some bytes of it, at least one.
struct FileBlocks {
    uint32_t first, last;
};
FileBlocks file_blocks(const fetch::RemoteFile& file, uint64_t offset, uint64_t size) {
    return {uint32_t(offset / file.block_bytes()), uint32_t((offset + size - 1) / file.block_bytes())};
}

bool is_there(const fetch::RemoteFile& file, uint64_t offset, uint64_t size) {
    const FileBlocks blocks = file_blocks(file, offset, size);
    for (uint32_t block = blocks.first; block <= blocks.last; ++block)
        if (file.block(block).empty()) return false;
    return true;
}

void add_wants(std::vector<fetch::Want>& wants, const fetch::RemoteFile& file, uint64_t offset, uint64_t size,
               float priority) {
    const FileBlocks blocks = file_blocks(file, offset, size);
    for (uint32_t block = blocks.first; block <= blocks.last; ++block) wants.push_back({block, priority});
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
        const splat::Model* model = nullptr;
    };

    fetch::Connection connection;
    std::map<std::string, File> files;  // by URL
    std::vector<Place> places;          // by model
    Counters before;

    // Asks for what wants_left() names, which is what a first picture needs or more, until it names nothing.
    template <class WantsLeft>
    void bring(const std::string& url, const WantsLeft& wants_left) {
        fetch::RemoteFile& file = *files.at(url).file;
        const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(kOpenTimeout_s);
        for (std::vector<fetch::Want> wants = wants_left(file); !wants.empty();) {
            add_wants(wants, file, 0, std::min(kFirstPictureBytes, file.bytes()), 1);
            file.want(wants);
            if (!file.failure().empty()) throw core::Error(url + ": " + file.failure());
            if (std::chrono::steady_clock::now() > until)
                throw core::Error(
                    url + (file.trouble().empty() ? ": the server does not answer" : ": " + file.trouble()));
            connection.wait(1);
            wants = wants_left(file);
        }
    }
    void bring_bytes(const std::string& url, uint64_t bytes) {
        bring(url, [&](const fetch::RemoteFile& file) {
            std::vector<fetch::Want> wants;
            const uint64_t wanted = std::min(bytes, file.bytes());
            if (!is_there(file, 0, wanted)) add_wants(wants, file, 0, wanted, 1);
            return wants;
        });
    }

    // Of all the daemon has done; only where it serves no others are these this program's.
    Counters daemon_counters() {
        const core::Json status = core::Json::parse(connection.status());
        Counters c{status.value("body_bytes", uint64_t(0)), status.value("requests", uint64_t(0))};
        for (const core::Json& server : status.value("servers", core::Json::array())) {
            c.round_trip_s = std::max(c.round_trip_s, server.value("round_trip_ms", 0.0) / 1000);
            c.bytes_per_s = std::max(c.bytes_per_s, server.value("bytes_per_s", 0.0));
            c.window_bytes = std::max(c.window_bytes, server.value("window_bytes", uint64_t(0)));
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
    state_->bring_bytes(url, splat::kBlocksAt);
    const uint64_t head = std::min<uint64_t>(splat::kBlocksAt, known.file->bytes());
    state_->bring_bytes(url, splat::header_extent({known.file->block(0).data(), head}));
    return std::make_unique<RemoteSource>(url, *known.file);
}

void RemoteModels::bring_first_picture(const std::string& url) {
    state_->bring_bytes(url, kFirstPictureBytes);
}

void RemoteModels::bring_blocks(const std::string& url, const splat::Model& model, uint64_t blocks) {
    state_->bring(url, [&](const fetch::RemoteFile& file) {
        model.take_stock();
        std::vector<fetch::Want> wants;
        for (uint64_t block = 0; block < std::min(blocks, model.blocks_present()); ++block) {
            if (model.is_there(block)) continue;
            const splat::CodedPlace next = model.next_bytes(block).place;
            add_wants(wants, file, next.offset, next.size, 1);
        }
        return wants;
    });
}

void RemoteModels::place(const std::string& url, size_t place, const splat::Model& model) {
    if (state_->places.size() <= place) state_->places.resize(place + 1);
    state_->places[place] = {&state_->files.at(url), &model};
}

void RemoteModels::ask(std::span<const BlockRequest> requests) {
    std::map<State::File*, std::vector<fetch::Want>> wants;
    for (const BlockRequest& request : requests) {
        const State::Place& place = state_->places[request.model];
        const splat::CodedPlace next = place.model->next_bytes(request.block).place;
        add_wants(wants[place.file], *place.file->file, next.offset, next.size, request.priority);
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

uint64_t RemoteModels::most_bytes(const BlockRequest& request) const {
    const State::Place& place = state_->places[request.model];
    const fetch::RemoteFile& file = *place.file->file;
    const splat::FoundPlace next = place.model->next_bytes(request.block);
    uint64_t bytes = 0;
    const FileBlocks blocks = file_blocks(file, next.place.offset, next.place.size);
    for (uint32_t block = blocks.first; block <= blocks.last; ++block)
        bytes += file.block(block).empty() ? file.block_bytes() : 0;
    if (next.is_block) return bytes;
    // Behind the page are others, at most, and the block, which begin and end anywhere.
    const uint64_t pages = place.model->coded()->index().levels() - 1;
    return bytes + pages * (splat::kMostPageBytes + file.block_bytes()) + place.model->header().block_size +
           file.block_bytes();
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
