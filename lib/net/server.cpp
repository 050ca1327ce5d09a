#include "net/server.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include "core/messages.h"

namespace net {

namespace {

// What the system keeps unsent for a connection, beyond what is on its way: little, so that an answer can
// still be changed before it is sent.
constexpr int kUnsentBytes = 32 << 10;
constexpr int kUnixBufferBytes = 64 << 10;
constexpr double kPauseSeconds = 1;

void prepare(int socket) {
    const int on = 1;
    if (::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on) != 0) {  // not TCP
        ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kUnixBufferBytes, sizeof kUnixBufferBytes);
        return;
    }
    ::setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentBytes, sizeof kUnsentBytes);
    // A peer that vanished without a word is found out.
    ::setsockopt(socket, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
}

void require_stream(int fd, const char* name) {
    struct stat status = {};
    if (::fstat(fd, &status) != 0 || !(S_ISFIFO(status.st_mode) || S_ISSOCK(status.st_mode)))
        throw core::Error(
            std::string(name) +
            ": is no pipe or socket that a client is at the other end of; --listen waits for clients");
}

void add(ConnectionCounts& sum, const ConnectionCounts& more) {
    sum.bytes_in += more.bytes_in;
    sum.bytes_out += more.bytes_out;
    sum.frames_in += more.frames_in;
    sum.frames_out += more.frames_out;
}

}  // namespace

Server::Server(EventLoop& loop, const ServerLimits& limits, MakeSession make_session,
               std::vector<std::byte> refusal)
    : loop_(loop), limits_(limits), make_session_(std::move(make_session)), refusal_(std::move(refusal)) {
    allow_many_descriptors();
}

Server::~Server() {
    for (const Listener& listener : listeners_) loop_.unwatch(listener.descriptor());
    for (const EventLoop::TimerId pause : pauses_) loop_.cancel(pause);
}

void Server::listen(Listener listener) {
    const size_t index = listeners_.size();
    listeners_.push_back(std::move(listener));
    pauses_.push_back(0);
    loop_.watch(listeners_.back().descriptor(), EPOLLIN, [this, index](uint32_t) { accept(index); });
}

void Server::accept(size_t listener) {
    const int listening = listeners_[listener].descriptor();
    for (;;) {
        core::Descriptor socket(::accept4(listening, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
        if (!socket) {
            // Out of descriptors: those who wait are let in when others have gone.
            if (errno == EMFILE || errno == ENFILE) {
                loop_.change(listening, 0);
                pauses_[listener] =
                    loop_.after(kPauseSeconds, [this, listening] { loop_.change(listening, EPOLLIN); });
            }
            return;
        }
        if (clients_.size() >= limits_.most_connections) {
            refuse(socket);
            continue;
        }
        prepare(socket.get());
        let_in(std::make_unique<Connection>(loop_, std::move(socket), limits_.connection,
                                            [this](Connection& connection) { gone(connection); }));
    }
}

// What fits into an empty socket is sent, or nothing.
void Server::refuse(const core::Descriptor& socket) {
    ++past_.refused;
    if (refusal_.empty()) return;
    const std::vector<std::byte> frame = to_frame(refusal_);
    ::send(socket.get(), frame.data(), frame.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void Server::let_in(std::unique_ptr<Connection> connection) {
    Connection& added = *connection;
    ++past_.seen;
    Client& client = clients_[&added];
    client.connection = std::move(connection);
    std::unique_ptr<Session> session = make_session_(added);
    client.session = session.get();
    added.start(std::move(session));
}

void Server::serve_one(core::Descriptor in, core::Descriptor out) {
    require_stream(in.get(), "standard input");
    require_stream(out.get(), "standard output");
    is_for_one_ = true;
    let_in(std::make_unique<Connection>(loop_, std::move(in), std::move(out), limits_.connection,
                                        [this](Connection& connection) { gone(connection); }));
}

void Server::gone(Connection& connection) {
    if (!connection.failure().empty()) {
        ++past_.dropped;
        core::warn("client dropped: " + connection.failure());
    }
    add(past_.traffic, connection.counts());
    clients_.erase(&connection);
    if (is_for_one_) loop_.stop();
}

ServerCounts Server::counts() const {
    ServerCounts counts = past_;
    counts.connections = clients_.size();
    for (const auto& [key, client] : clients_) {
        add(counts.traffic, client.connection->counts());
        if (!client.connection->failure().empty()) ++counts.dropped;
    }
    return counts;
}

void Server::for_each(const std::function<void(const Session&)>& use) const {
    for (const auto& [key, client] : clients_) use(*client.session);
}

core::Json to_json(const ServerCounts& counts) {
    return {{"clients", counts.connections},       {"clients_seen", counts.seen},
            {"clients_refused", counts.refused},   {"clients_dropped", counts.dropped},
            {"bytes_in", counts.traffic.bytes_in}, {"bytes_out", counts.traffic.bytes_out}};
}

}  // namespace net
