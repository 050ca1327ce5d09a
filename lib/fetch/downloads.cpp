#include "fetch/downloads.h"

#include "core/error.h"
#include "fetch/download.h"

namespace fetch {

namespace {

constexpr size_t kMostServers = 1000;

}  // namespace

// ---- Downloads ----

Downloads::Downloads(net::EventLoop& loop, Store& store, const TransportOptions& transport,
                     const DownloadOptions& options)
    : loop_(loop), store_(store), options_(options), transport_(loop, transport) {}

Downloads::~Downloads() {
    for (const auto& [name, server] : servers_) loop_.cancel(server->timer);
}

Downloads::Server& Downloads::server_for(const std::string& url) {
    const std::string name = server_of(url);
    if (servers_.size() >= kMostServers)
        std::erase_if(servers_, [](const auto& known) {
            return known.second->downloads.empty() && known.second->timer == 0;
        });
    std::unique_ptr<Server>& server = servers_[name];
    if (!server) {
        server = std::make_unique<Server>();
        server->name = name;
    }
    return *server;
}

std::unique_ptr<Subscription> Downloads::open(const std::string& url, Subscriber& subscriber) {
    if (const auto refusal = refusals_.find(url); refusal != refusals_.end()) {
        if (net::steady_seconds() < refusal->second.until) throw core::Error(refusal->second.why);
        refusals_.erase(refusal);
    }
    ++counts_.opens;
    std::shared_ptr<Download>& download = downloads_[url];
    try {
        // One that is over is left to those who still hold it.
        if (!download || download->is_over_)
            download = std::make_shared<Download>(*this, server_for(url), url);
    } catch (const core::Error&) {
        downloads_.erase(url);
        throw;
    }
    std::unique_ptr<Subscription> subscription(new Subscription(download, subscriber));
    if (download->entry_) {
        ++counts_.opens_from_cache;
        download->check_if_old();
        loop_.after(0, [weak = std::weak_ptr(download)] {
            if (const auto opened = weak.lock(); opened && !opened->is_over_) opened->tell_opened();
        });
    }
    pump_soon(download->server_);
    return subscription;
}

void Downloads::forget(Download& download) {
    if (!download.subscriptions_.empty() || download.requests_ > 0) return;
    const auto found = downloads_.find(download.url_);
    if (found != downloads_.end() && found->second.get() == &download) downloads_.erase(found);
}

// After what else there is to do now: many messages and answers make one look at the queues.
void Downloads::pump_soon(Server& server) {
    if (server.timer != 0) return;
    server.timer = loop_.after(0, [this, &server] {
        server.timer = 0;
        pump(server);
    });
}

Download* Downloads::best_of(Server& server) {
    const double now = net::steady_seconds();
    Download* best = nullptr;
    float most = -1;
    for (Download* download : server.downloads) {
        if (!download->is_ready(now)) continue;
        const float urgency = download->urgency();
        if (urgency > most) {
            most = urgency;
            best = download;
        }
    }
    return best;
}

void Downloads::pump(Server& server) {
    const double now = net::steady_seconds();
    if (now < server.paused_until) {
        server.timer = loop_.after(server.paused_until - now, [this, &server] {
            server.timer = 0;
            pump(server);
        });
        return;
    }
    while (server.requests < server.streams) {
        const auto is_full = [&](uint64_t window) {
            return server.requests > 0 && server.link.in_flight_bytes() >= window;
        };
        if (is_full(server.link.window_bytes())) return;
        Download* const best = best_of(server);
        if (!best || (best->urgency() < kIdlePriority && is_full(server.link.idle_window_bytes()))) break;
        best->start_next();
    }
    if (server.link.in_flight_bytes() < server.link.window_bytes()) server.link.left_unfilled();
}

uint64_t Downloads::disk_bytes_in_flight() const {
    uint64_t bytes = 0;
    for (const auto& [name, server] : servers_)
        bytes += disk_bytes(server->link.in_flight_bytes()) + server->requests * disk_bytes(0);
    return bytes;
}

size_t Downloads::requests_in_flight() const {
    size_t requests = 0;
    for (const auto& [name, server] : servers_) requests += server->requests;
    return requests;
}

std::vector<Downloads::ServerState> Downloads::servers() const {
    std::vector<ServerState> states;
    for (const auto& [name, server] : servers_)
        states.push_back(
            {name, server->link.bytes_per_s(), server->link.round_trip_s(), server->link.window_bytes()});
    return states;
}

}  // namespace fetch
