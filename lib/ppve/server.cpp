#include "ppve/server.h"

#include "ppve/status.h"

namespace ppve {

namespace {

// What sessions share.
struct Shared {
    Sampler& sampler;
    ServerOptions options;
    Server::Answered answered;
    SessionCounts counts{};
    std::function<core::Json()> status{};
};

class Client final : public net::Session {
  public:
    Client(net::Connection& connection, Shared& shared)
        : connection_(connection),
          shared_(shared),
          session_(shared.sampler, shared.options.scene, shared.options.session) {
        connection_.send(format(session_.welcome()));
    }

    void received(std::span<const std::byte> body) override {
        Message message = parse(body, "request");
        if (std::holds_alternative<StatusQuery>(message))
            return connection_.send(format(Status{shared_.status().dump()}));
        SessionCounts& counts = shared_.counts;
        const auto* request = std::get_if<Request>(&message);
        const uint64_t id = request ? request->id : 0;
        counts.requests += request != nullptr;
        for (const Refusal& refusal : session_.take(std::move(message))) {
            // Else of the one that waited.
            ++(refusal.id == id ? counts.requests_refused : counts.requests_replaced);
            connection_.send(format(refusal));
        }
        if (session_.has_request()) connection_.ask_turn();
    }

    void turn() override {
        if (!session_.has_request()) return;
        AnswerReport report;
        connection_.send(session_.answer(report));
        shared_.counts.add(report);
        shared_.answered(report);
        if (is_ended_) connection_.finish();
    }

    // A request that waits is answered still: the client of a pipe may close it at once.
    void input_ended(net::Connection& connection) override {
        is_ended_ = true;
        if (!session_.has_request()) connection.finish();
    }

    std::vector<std::byte> farewell(const std::string& why) override { return format(Refusal{0, why}); }

    const Octree& tree() const { return session_.tree(); }

  private:
    net::Connection& connection_;
    Shared& shared_;
    ppve::Session session_;
    bool is_ended_ = false;
};

}  // namespace

struct Server::State {
    Shared shared;
    net::Server connections;

    State(net::EventLoop& loop, Sampler& sampler, const ServerOptions& options, Answered answered)
        : shared{sampler, options, std::move(answered)},
          connections(
              loop, options.server,
              [this](net::Connection& connection) { return std::make_unique<Client>(connection, shared); },
              format(Refusal{0, "this server has as many clients as it takes"})) {
        shared.status = [this] { return status(); };
    }

    core::Json status() const {
        SessionMemory memory{.most_points = shared.options.session.most_points};
        connections.for_each([&](const net::Session& session) {
            const Octree& tree = static_cast<const Client&>(session).tree();
            memory.points += tree.points(), memory.bytes += tree.bytes();
        });
        return status_of(connections.counts(), shared.counts, memory);
    }
};

Server::Server(net::EventLoop& loop, Sampler& sampler, const ServerOptions& options, Answered answered)
    : state_(std::make_unique<State>(loop, sampler, options, std::move(answered))) {}

Server::~Server() = default;

net::Server& Server::connections() {
    return state_->connections;
}

core::Json Server::status() const {
    return state_->status();
}

}  // namespace ppve
