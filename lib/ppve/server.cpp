#include "ppve/server.h"

namespace ppve {

namespace {

class Client final : public net::Session {
  public:
    Client(net::Connection& connection, Sampler& sampler, const ServerOptions& options,
           const Server::Answered& answered)
        : connection_(connection), session_(sampler, options.scene, options.session), answered_(answered) {
        connection_.send(format(session_.welcome()));
    }

    void received(std::span<const std::byte> body) override {
        for (const Refusal& refusal : session_.take(parse(body, "request")))
            connection_.send(format(refusal));
        if (session_.has_request()) connection_.ask_turn();
    }

    void turn() override {
        if (!session_.has_request()) return;
        AnswerReport report;
        connection_.send(session_.answer(report));
        answered_(report);
        if (is_ended_) connection_.finish();
    }

    // A request that waits is answered still: the client of a pipe may close it at once.
    void input_ended(net::Connection& connection) override {
        is_ended_ = true;
        if (!session_.has_request()) connection.finish();
    }

    std::vector<std::byte> farewell(const std::string& why) override { return format(Refusal{0, why}); }

  private:
    net::Connection& connection_;
    ppve::Session session_;
    const Server::Answered& answered_;
    bool is_ended_ = false;
};

}  // namespace

Server::Server(net::EventLoop& loop, Sampler& sampler, const ServerOptions& options, Answered answered)
    : connections_(
          loop, options.server,
          [&sampler, options, answered = std::move(answered)](net::Connection& connection) {
              return std::make_unique<Client>(connection, sampler, options, answered);
          },
          format(Refusal{0, "this server has as many clients as it takes"})) {}

}  // namespace ppve
