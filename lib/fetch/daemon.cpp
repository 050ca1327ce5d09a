#include "fetch/daemon.h"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <deque>
#include <map>

#include "core/json.h"
#include "core/messages.h"
#include "fetch/downloads.h"
#include "fetch/messages.h"
#include "fetch/unix_socket.h"
#include "net/listener.h"
#include "net/stop_signals.h"

namespace fetch {

namespace {

constexpr size_t kMostWaiting = 64;  // messages that a client has not read
constexpr int kMessagesATurn = 16;   // of one client, before others have theirs
constexpr size_t kMostListed = 200;  // servers in a status

}  // namespace

struct Daemon::State {
    struct Client;

    // A file that a client has open.
    struct Stream : Subscriber {
        Client& client;
        uint32_t id;
        std::unique_ptr<Subscription> subscription;

        Stream(Client& owner, uint32_t number) : client(owner), id(number) {}
        void opened(const Entry& entry) override;
        void arrived() override;
        void ended(Reason reason, const std::string& why) override;
        void trouble(Reason reason, const std::string& why) override;
        void tell(ReplyKind kind, Reason reason, const std::string& why);
    };

    struct Waiting {
        std::vector<std::byte> message;
        std::vector<Descriptor> descriptors;
    };

    struct Client {
        State& daemon;
        Descriptor socket;
        std::map<uint32_t, std::unique_ptr<Stream>> streams;
        std::deque<Waiting> waiting;
        bool is_dropped = false;

        Client(State& state, Descriptor connection) : daemon(state), socket(std::move(connection)) {}
        void on_event(uint32_t events);
        void take(const Request& request);
        void send(const Reply& reply, std::span<const int> descriptors = {});
        void send_waiting();
        void drop(const std::string& why);
    };

    DaemonOptions options;
    net::EventLoop loop;
    net::StopSignals stop_signals{loop};
    Store store;
    Downloads downloads;
    Descriptor listener;
    bool is_own_socket = false;
    std::map<int, std::unique_ptr<Client>> clients;  // by descriptor
    net::EventLoop::TimerId idle_timer = 0;
    uint64_t clients_seen = 0, clients_dropped = 0, clients_refused = 0;

    explicit State(const DaemonOptions& given);
    ~State();
    void accept_clients();
    void remove(Client& client);
    void watch_idleness();
    core::Json status();
    Reply answer(const Request& request);
    Reply evict(const Request& request);
};

// ---- a client ----

void Daemon::State::Stream::opened(const Entry& entry) {
    Reply reply;
    reply.kind = ReplyKind::opened;
    reply.stream = id;
    reply.file_bytes = entry.facts().bytes;
    reply.block_bytes = entry.block_bytes();
    const int descriptors[] = {entry.data_for_clients(), entry.map_for_clients(), entry.use_for_clients()};
    client.send(reply, descriptors);
}

void Daemon::State::Stream::arrived() {
    Reply reply;
    reply.kind = ReplyKind::arrived;
    reply.stream = id;
    client.send(reply);
}

void Daemon::State::Stream::ended(Reason reason, const std::string& why) {
    tell(ReplyKind::ended, reason, why);
}

void Daemon::State::Stream::trouble(Reason reason, const std::string& why) {
    tell(ReplyKind::trouble, reason, why);
}

void Daemon::State::Stream::tell(ReplyKind kind, Reason reason, const std::string& why) {
    Reply reply;
    reply.kind = kind;
    reply.stream = id;
    reply.reason = reason;
    reply.text = why;
    client.send(reply);
}

void Daemon::State::Client::send(const Reply& reply, std::span<const int> descriptors) {
    if (is_dropped) return;
    const std::vector<std::byte> message = to_bytes(reply);
    try {
        if (waiting.empty() && send_message(socket.get(), message, descriptors)) return;
    } catch (const core::Error& error) {
        drop(error.what());
        return;
    }
    if (waiting.size() >= kMostWaiting) return drop("does not read what it is sent");
    Waiting later{message, {}};
    for (const int fd : descriptors) later.descriptors.emplace_back(::fcntl(fd, F_DUPFD_CLOEXEC, 3));
    waiting.push_back(std::move(later));
    daemon.loop.change(socket.get(), EPOLLIN | EPOLLOUT);
}

void Daemon::State::Client::send_waiting() {
    while (!waiting.empty()) {
        std::vector<int> descriptors;
        for (const Descriptor& fd : waiting.front().descriptors) descriptors.push_back(fd.get());
        if (!send_message(socket.get(), waiting.front().message, descriptors)) return;
        waiting.pop_front();
    }
    daemon.loop.change(socket.get(), EPOLLIN);
}

void Daemon::State::Client::on_event(uint32_t events) {
    try {
        if (events & EPOLLOUT) send_waiting();
        Received received;
        for (int i = 0; i < kMessagesATurn && !is_dropped && receive_message(socket.get(), 0, received);
             ++i) {
            if (received.is_closed) return drop("");
            take(parse_request(received.message));
        }
    } catch (const core::Error& error) {
        drop(error.what());
    }
}

void Daemon::State::Client::take(const Request& request) {
    switch (request.kind) {
        case RequestKind::open: {
            if (streams.size() >= kMostStreams || streams.contains(request.stream))
                throw core::Error("opens too many files, or one twice");
            auto stream = std::make_unique<Stream>(*this, request.stream);
            try {
                stream->subscription = daemon.downloads.open(request.url, *stream);
            } catch (const core::Error& error) {
                stream->ended(Reason::failed, error.what());
                return;
            }
            streams[request.stream] = std::move(stream);
            return;
        }
        case RequestKind::want: {
            const auto stream = streams.find(request.stream);
            // It may have been closed while this was on its way; the client knows.
            if (stream != streams.end()) stream->second->subscription->want(request.wants);
            return;
        }
        case RequestKind::close:
            streams.erase(request.stream);
            return;
        case RequestKind::status:
        case RequestKind::evict:
        case RequestKind::stop:
            send(daemon.answer(request));
            return;
    }
}

// It may be called from within the calls of a stream, so that what is dropped goes later.
void Daemon::State::Client::drop(const std::string& why) {
    if (is_dropped) return;
    is_dropped = true;
    if (!why.empty()) {
        ++daemon.clients_dropped;
        core::warn(core::text("client %d dropped: %s", socket.get(), why.c_str()));
    }
    daemon.loop.unwatch(socket.get());
    daemon.loop.after(0, [this] { daemon.remove(*this); });
}

// ---- the daemon ----

Daemon::State::State(const DaemonOptions& given)
    : options(given),
      store(options.folder, options.limit_bytes),
      downloads(loop, store, options.transport, options.downloads),
      listener(net::inherited_socket(SOCK_SEQPACKET)) {
    net::allow_many_descriptors();
    if (!listener) {
        listener = listen_in(store.folder(), store.path());
        is_own_socket = true;
    }
    loop.watch(listener.get(), EPOLLIN, [this](uint32_t) { accept_clients(); });
    watch_idleness();
}

Daemon::State::~State() {
    clients.clear();
    loop.unwatch(listener.get());
    if (is_own_socket) ::unlinkat(store.folder(), kSocketName, 0);
}

void Daemon::State::accept_clients() {
    for (;;) {
        Descriptor socket(::accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
        if (!socket) {
            // Out of descriptors: those who wait are let in when others have gone.
            if (errno == EMFILE || errno == ENFILE) {
                loop.change(listener.get(), 0);
                loop.after(1, [this] { loop.change(listener.get(), EPOLLIN); });
            }
            return;
        }
        if (peer_of(socket.get()) != ::geteuid() || clients.size() >= options.most_clients) {
            ++clients_refused;
            core::warn(core::text("client of user %u refused", peer_of(socket.get())));
            continue;
        }
        const int fd = socket.get();
        auto client = std::make_unique<Client>(*this, std::move(socket));
        Client& added = *client;
        clients[fd] = std::move(client);
        ++clients_seen;
        loop.cancel(idle_timer);
        loop.watch(fd, EPOLLIN, [&added](uint32_t events) { added.on_event(events); });
    }
}

void Daemon::State::remove(Client& client) {
    clients.erase(client.socket.get());
    watch_idleness();
}

void Daemon::State::watch_idleness() {
    if (options.idle_exit_s <= 0 || !clients.empty()) return;
    loop.cancel(idle_timer);
    idle_timer = loop.after(options.idle_exit_s, [this] { loop.stop(); });
}

core::Json Daemon::State::status() {
    const DownloadCounts& counts = downloads.counts();
    const TransportCounts& transport = downloads.transport_counts();
    core::Json servers = core::Json::array();
    for (const Downloads::ServerState& server : downloads.servers()) {
        if (servers.size() == kMostListed) break;
        servers.push_back({{"server", server.name},
                           {"bytes_per_s", uint64_t(server.bytes_per_s)},
                           {"round_trip_ms", server.round_trip_s * 1000},
                           {"window_bytes", server.window_bytes}});
    }
    return {{"folder", store.path()},
            {"limit_bytes", store.limit_bytes()},
            {"held_bytes", store.held_bytes()},
            {"evicted_bytes", store.evicted_bytes()},
            {"files_cached", store.entry_count()},
            {"files_open", downloads.size()},
            {"opens", counts.opens},
            {"opens_from_cache", counts.opens_from_cache},
            {"checks", counts.checks},
            {"requests", transport.requests},
            {"requests_in_flight", downloads.requests_in_flight()},
            {"header_bytes", transport.header_bytes},
            {"body_bytes", transport.body_bytes},
            {"blocks_stored", counts.blocks_stored},
            {"retries", counts.retries},
            {"files_changed", counts.changed},
            {"clients", clients.size()},
            {"clients_seen", clients_seen},
            {"clients_dropped", clients_dropped},
            {"clients_refused", clients_refused},
            {"servers", std::move(servers)}};
}

Reply Daemon::State::evict(const Request& request) {
    Reply reply;
    const uint64_t before = store.evicted_bytes(), held = store.held_bytes();
    if (request.url.empty()) {
        store.shrink_to(request.keep_bytes);
    } else {
        if (downloads.is_open(request.url)) {
            reply.text = request.url + ": is in use";
            return reply;
        }
        store.remove(request.url);
    }
    const uint64_t left = store.held_bytes();
    const uint64_t freed = std::max(store.evicted_bytes() - before, held - std::min(held, left));
    reply.is_right = true;
    reply.text = core::Json{{"evicted_bytes", freed}, {"held_bytes", left}}.dump();
    return reply;
}

Reply Daemon::State::answer(const Request& request) {
    if (request.kind == RequestKind::evict) return evict(request);
    Reply reply;
    reply.is_right = true;
    reply.text = status().dump();
    if (request.kind == RequestKind::stop) loop.after(0, [this] { loop.stop(); });
    return reply;
}

Daemon::Daemon(const DaemonOptions& options) : state_(std::make_unique<State>(options)) {}

Daemon::~Daemon() = default;

void Daemon::run() {
    state_->loop.run();
}

}  // namespace fetch
