#include "pm/follow.h"

#include <algorithm>
#include <limits>
#include <thread>

#include "net/address.h"
#include "net/event_loop.h"

namespace pm {

namespace {

constexpr double kFirstPauseSeconds = 0.05, kLongestPauseSeconds = 5;

}  // namespace

core::Json to_json(const FrameCosts& costs) {
    return {{"frame", costs.frame},
            {"t", costs.time_s},
            {"bytes_up", costs.bytes_up},
            {"bytes_down", costs.bytes_down},
            {"requests", costs.requests},
            {"splits_received", costs.splits_received},
            {"splits", costs.splits},
            {"faces", costs.faces},
            {"is_complete", costs.is_complete},
            {"first_packet_ms", costs.first_packet_ms},
            {"done_ms", costs.done_ms},
            {"refine_ms", costs.refine_ms},
            {"resumed", costs.resumed}};
}

Connect connector(const net::Address& address, double timeout_s) {
    return [address, timeout_s] {
        return net::FrameStream(net::connect_to(address, timeout_s), net::to_text(address),
                                kMostServerMessageBytes);
    };
}

Follower::Follower(Connect connect, std::string name, const FollowOptions& options,
                   std::unique_ptr<ClientState> state)
    : connect_(std::move(connect)), name_(std::move(name)), options_(options) {
    this->connect(std::move(state));
    told_splits_ = client_->state().replica().split_count();
}

void Follower::connect(std::unique_ptr<ClientState> state) {
    auto client = std::make_unique<Client>(connect_(), options_.timeout_s);
    if (state)
        client->resume(name_, std::move(*state));
    else
        client->open(name_, options_.service);
    client_ = std::move(client);
}

// Goes on where the connection was lost, after a pause that grows from one loss to the next.
void Follower::reconnect() {
    auto state = std::make_unique<ClientState>(client_->take_state());
    bytes_up_ += client_->stream().bytes_sent();
    bytes_down_ += client_->stream().bytes_received();
    requests_ += client_->counts().requests_sent;
    if (state->replica().split_count() != splits_at_loss_) losses_ = 0;
    splits_at_loss_ = state->replica().split_count();
    for (;;) {
        const std::string name = client_->stream().name();
        if (++losses_ > options_.most_retries)
            throw core::Error(name + ": the connection was lost " + std::to_string(losses_) +
                              " times in a row; --state keeps what has come for --resume");
        const double pause =
            std::min(kFirstPauseSeconds * double(1 << std::min(losses_, 10)), kLongestPauseSeconds);
        std::this_thread::sleep_for(std::chrono::duration<double>(pause));
        try {
            // The state must outlive an attempt that fails.
            auto again = std::make_unique<ClientState>(ClientState::from_bytes(state->to_bytes(), name));
            connect(std::move(again));
            ++resumed_;
            return;
        } catch (const net::ConnectionLost&) {
        } catch (const net::CannotConnect&) {
        }
    }
}

bool Follower::ask(const View& view) {
    view_ = view;
    for (;;) {
        try {
            return client_->look_at(view, options_.culling);
        } catch (const net::ConnectionLost&) {
            reconnect();
        }
    }
}

void Follower::wait_for_end(double until_s, FrameCosts& costs) {
    double last = net::steady_seconds();
    while (!client_->is_complete()) {
        const double now = net::steady_seconds();
        if (now >= until_s) return;
        if (now - last > options_.timeout_s)
            throw core::Error(client_->stream().name() + ": the server does not answer");
        try {
            if (!client_->wait(std::min(until_s - now, options_.timeout_s))) continue;
        } catch (const net::ConnectionLost&) {
            reconnect();
            client_->look_at(view_, options_.culling);
        }
        last = net::steady_seconds();
        if (costs.first_packet_ms == 0) costs.first_packet_ms = (last - asked_s_) * 1000;
    }
    if (costs.first_packet_ms != 0) costs.done_ms = (net::steady_seconds() - asked_s_) * 1000;
}

void Follower::look_through(int width, int height, double threshold_px) {
    options_.width = width, options_.height = height;
    options_.threshold_px = threshold_px;
}

FrameCosts Follower::show(int number, const geom::Camera& camera, std::optional<double> next_time_s) {
    FrameCosts costs;
    costs.frame = number;
    costs.time_s = camera.time_s;
    if (begun_s_ < 0) begun_s_ = net::steady_seconds(), path_begin_s_ = camera.time_s;
    double until = std::numeric_limits<double>::infinity();
    if (options_.in_real_time) {
        const double early = begun_s_ + (camera.time_s - path_begin_s_) - net::steady_seconds();
        if (early > 0) std::this_thread::sleep_for(std::chrono::duration<double>(early));
        if (next_time_s) until = begun_s_ + (*next_time_s - path_begin_s_);
    }
    asked_s_ = net::steady_seconds();
    ask(make_view(geom::make_view(camera, options_.width, options_.height), options_.threshold_px));
    wait_for_end(std::min(until, asked_s_ + patience_s_), costs);
    costs.is_complete = client_->is_complete();
    const double before_refining = net::steady_seconds();
    const Front& front = client_->refine();
    costs.refine_ms = (net::steady_seconds() - before_refining) * 1000;
    costs.splits = front.split_count();
    costs.faces = front.face_count();
    const uint64_t splits = client_->state().replica().split_count();
    costs.bytes_up = bytes_up() - std::exchange(told_up_, bytes_up());
    costs.bytes_down = bytes_down() - std::exchange(told_down_, bytes_down());
    const uint64_t requests = requests_ + client_->counts().requests_sent;
    costs.requests = requests - std::exchange(told_requests_, requests);
    costs.splits_received = splits - std::exchange(told_splits_, splits);
    costs.resumed = std::exchange(resumed_, 0);
    return costs;
}

}  // namespace pm
