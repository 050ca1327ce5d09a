// A server of framed connections (connection.h): lets clients in, up to a limit, and keeps count.
#pragma once

#include <functional>
#include <memory>
#include <unordered_map>
#include <vector>

#include "core/json.h"
#include "net/connection.h"
#include "net/listener.h"

namespace net {

struct ServerLimits {
    size_t most_connections = 1000;
    ConnectionLimits connection;
};

struct ServerCounts {
    uint64_t connections = 0;  // now
    uint64_t seen = 0;         // let in since the start
    uint64_t refused = 0;      // there were too many
    uint64_t dropped = 0;      // did wrong
    ConnectionCounts traffic;  // of all
};

// As --status of every server has them: clients, clients_seen, clients_refused, clients_dropped, bytes_in,
// bytes_out.
core::Json to_json(const ServerCounts& counts);

// Not thread-safe; `loop` outlives it.
class Server {
  public:
    using MakeSession = std::function<std::unique_ptr<Session>(Connection&)>;

    // `refusal` is the body of what is said to a client that is one too many; empty: nothing.
    Server(EventLoop& loop, const ServerLimits& limits, MakeSession make_session,
           std::vector<std::byte> refusal = {});
    ~Server();

    // Any number of times.
    void listen(Listener listener);
    // One connection on two ends of pipes, or of one socket: what --stdio stands for.  Throws core::Error
    // where one of them is neither.  When it is over, the loop stops.
    void serve_one(core::Descriptor in, core::Descriptor out);

    ServerCounts counts() const;

    // The sessions that are now, in no order.
    void for_each(const std::function<void(const Session&)>& use) const;

  private:
    struct Client {
        std::unique_ptr<Connection> connection;
        Session* session = nullptr;  // the connection owns it
    };
    void accept(size_t listener);
    void refuse(const core::Descriptor& socket);
    void let_in(std::unique_ptr<Connection> connection);
    void gone(Connection& connection);

    EventLoop& loop_;
    ServerLimits limits_;
    MakeSession make_session_;
    std::vector<std::byte> refusal_;
    std::vector<Listener> listeners_;
    std::vector<EventLoop::TimerId> pauses_;
    std::unordered_map<const Connection*, Client> clients_;
    bool is_for_one_ = false;
    ServerCounts past_;  // of connections that are over
};

}  // namespace net
