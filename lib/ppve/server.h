// Sessions on connections: the program ppve-sample, but for its options.
//
// All clients share one sampler and take turns at it, an answer at a time; an answer is made when the system
// has taken the one before, so that a client that does not read costs nothing but its place.  Its loops run
// in the process's one arena (core/parallel.h), however many clients there are.
#pragma once

#include <functional>
#include <memory>

#include "core/json.h"
#include "net/server.h"
#include "ppve/session.h"

namespace ppve {

struct ServerOptions {
    std::string scene;
    SessionLimits session;
    net::ServerLimits server;
};

// What a client may send at most, bytes.
constexpr size_t kMostRequestBytes = 1024 + kMostDeletions * sizeof(uint64_t);

class Server {
  public:
    using Answered = std::function<void(const AnswerReport&)>;

    // `loop` and `sampler` outlive it; `answered` is called after each answer.
    Server(net::EventLoop& loop, Sampler& sampler, const ServerOptions& options, Answered answered);

    ~Server();

    net::Server& connections();

    // Counters, as in ppve-sample(1); clients ask for them by StatusQuery.
    core::Json status() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ppve
