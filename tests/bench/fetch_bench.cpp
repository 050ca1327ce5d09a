// fetch_bench jump FOLDER URL:            how long the first useful block takes after a change of view.
// fetch_bench clients FOLDER URL COUNT:   how long so many clients wait who want blocks at the same time.
//
// Both ask the daemon that runs in FOLDER, for a file of which it has nothing yet, and print one JSON object.
//
// jump: blocks are wanted from the file's beginning on for a second or until half of the file is there, then
// others, from its end on; the first of those that comes is what the new view sees first.  Ten times, each
// with a part of the file of its own. clients: each opens the file and wants 16 blocks of its own, all at the
// same time; then all the same 16.
#include <poll.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/program.h"
#include "fetch/client.h"
#include "net/event_loop.h"

namespace {

using net::steady_seconds;

constexpr int kJumps = 10;
constexpr uint32_t kBlocksAClient = 16;
constexpr size_t kMostWanted = 4000;

double quantile(std::vector<double> values, double part) {
    std::sort(values.begin(), values.end());
    return values[size_t(part * double(values.size() - 1) + 0.5)];
}

std::vector<fetch::Want> wants_of(const fetch::RemoteFile& file, uint32_t first, uint32_t end) {
    std::vector<fetch::Want> wants;
    // Priorities that fall by less than what keeps neighbours apart, as those of a picture's.
    for (uint32_t block = first; block != end && wants.size() < kMostWanted; ++block)
        if (file.block(block).empty()) wants.push_back({block, 1 / (1 + 0.01f * float(block - first))});
    return wants;
}

double first_useful_s(fetch::Connection& connection, fetch::RemoteFile& file, uint32_t first, uint32_t end) {
    const uint32_t jump_at = first + (end - first) / 2;
    const double until = steady_seconds() + 1;
    while (steady_seconds() < until && file.block(jump_at - 1).empty()) {
        file.want(wants_of(file, first, jump_at));
        connection.wait(0.02);
    }
    const double start = steady_seconds();
    file.want(wants_of(file, jump_at, end));
    while (file.block(jump_at).empty()) connection.wait(1);
    return steady_seconds() - start;
}

void jump(const std::string& folder, const std::string& url) {
    fetch::Connection connection({.folder = folder, .program = "", .daemon_arguments = {}});
    const auto file = connection.open(url);
    std::vector<double> seconds;
    const uint32_t part = file->block_count() / (kJumps + 1);
    // The first part is for the estimates.
    for (uint32_t i = 0; i <= kJumps; ++i)
        seconds.push_back(first_useful_s(connection, *file, i * part, (i + 1) * part));
    seconds.erase(seconds.begin());
    const core::Json json{{"first_useful_s", quantile(seconds, 0.5)}, {"worst_s", quantile(seconds, 1)}};
    core::print(json.dump() + "\n");
}

struct Client {
    std::unique_ptr<fetch::Connection> connection;
    std::unique_ptr<fetch::RemoteFile> file;
    uint32_t first = 0;
    double done_s = 0;

    bool has_all() const {
        for (uint32_t i = 0; i != kBlocksAClient; ++i)
            if (file->block(first + i).empty()) return false;
        return true;
    }
    void want() const {
        std::vector<fetch::Want> wants;
        for (uint32_t i = 0; i != kBlocksAClient; ++i)
            if (file->block(first + i).empty()) wants.push_back({first + i, 1});
        if (!wants.empty()) file->want(std::move(wants));
    }
};

// Seconds that each waits from when all begin to want.
std::vector<double> serve(std::vector<Client>& clients) {
    const double start = steady_seconds();
    std::vector<pollfd> polls;
    std::vector<Client*> waiting;
    for (Client& client : clients) {
        client.want();
        waiting.push_back(&client);
    }
    while (!waiting.empty()) {
        std::erase_if(waiting, [&](Client* client) {
            const bool is_done = client->has_all();
            if (is_done) client->done_s = steady_seconds() - start;
            return is_done;
        });
        polls.clear();
        for (const Client* client : waiting) polls.push_back({client->connection->descriptor(), POLLIN, 0});
        if (polls.empty() || ::poll(polls.data(), polls.size(), 1000) <= 0) continue;
        for (size_t i = 0; i != polls.size(); ++i) {
            if (!polls[i].revents) continue;
            waiting[i]->connection->wait(0);
            waiting[i]->want();
        }
    }
    std::vector<double> seconds;
    for (const Client& client : clients) seconds.push_back(client.done_s);
    return seconds;
}

void many(const std::string& folder, const std::string& url, uint32_t count) {
    rlimit limit = {};
    ::getrlimit(RLIMIT_NOFILE, &limit);
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
    const double start = steady_seconds();
    std::vector<Client> clients(count);
    for (Client& client : clients) {
        client.connection = std::make_unique<fetch::Connection>(
            fetch::ClientOptions{.folder = folder, .program = "", .daemon_arguments = {}});
        client.file = client.connection->open(url);
    }
    const double opened = steady_seconds() - start;
    const uint32_t blocks = clients[0].file->block_count();
    if (blocks < 2 * kBlocksAClient) throw core::Error("the file is too short");
    for (uint32_t i = 0; i != count; ++i)
        clients[i].first = uint32_t(uint64_t{i} * kBlocksAClient % (blocks - 2 * kBlocksAClient));
    const std::vector<double> own = serve(clients);
    for (Client& client : clients) client.first = blocks - kBlocksAClient;
    const std::vector<double> same = serve(clients);
    const core::Json json{{"clients", count},
                          {"open_ms_each", opened * 1000 / count},
                          {"own_median_s", quantile(own, 0.5)},
                          {"own_worst_s", quantile(own, 1)},
                          {"own_bytes", uint64_t{count} * kBlocksAClient * clients[0].file->block_bytes()},
                          {"same_worst_s", quantile(same, 1)}};
    core::print(json.dump() + "\n");
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc == 4 && std::strcmp(argv[1], "jump") == 0) {
            jump(argv[2], argv[3]);
        } else if (argc == 5 && std::strcmp(argv[1], "clients") == 0) {
            many(argv[2], argv[3], uint32_t(std::max(1, std::atoi(argv[4]))));
        } else {
            std::fprintf(stderr, "usage: fetch_bench jump FOLDER URL | clients FOLDER URL COUNT\n");
            return 2;
        }
    } catch (const core::Error& error) {
        std::fprintf(stderr, "fetch_bench: %s\n", error.what());
        return 1;
    }
    core::write_standard_output("", true);
}
