#include "fetch/slow_link.h"

#include <algorithm>

namespace fetch {

namespace {

constexpr double kFirstWindow = 10 * 1460, kMostWindow = 1 << 30;

}  // namespace

void SlowLink::connect(long connection, int round_trips) {
    Connection made;
    made.open_at = net::steady_seconds() + round_trips * round_trip_s_;
    connections_[connection] = made;
}

double SlowLink::until_open_s(long connection) const {
    const auto found = connections_.find(connection);
    return found == connections_.end() ? 0 : std::max(0.0, found->second.open_at - net::steady_seconds());
}

double SlowLink::after_round_trips(Connection& connection, uint64_t bytes, double now) const {
    double ready = std::max({std::max(now, connection.open_at) + round_trip_s_, connection.last});
    if (connection.window == 0) connection.window = kFirstWindow;
    const double next_round = connection.round_began + round_trip_s_;
    const bool is_full = connection.in_round + double(bytes) > connection.window;
    if (ready >= next_round || is_full) {
        ready = std::max(ready, next_round);
        if (2 * (connection.in_round + double(bytes)) > connection.window)
            connection.window = std::min(2 * connection.window, kMostWindow);
        connection.round_began = ready;
        connection.in_round = 0;
    }
    connection.in_round += double(bytes);
    connection.last = ready;
    return ready;
}

void SlowLink::pass(long connection, uint64_t bytes, std::function<void()> arrive) {
    if (!is_slow()) {
        arrive();
        return;
    }
    const double ready = after_round_trips(connections_[connection], bytes, net::steady_seconds());
    const auto added = waiting_.emplace(ready, Packet{bytes, std::move(arrive)});
    if (added == waiting_.begin()) schedule();
}

double SlowLink::first_due() const {
    const auto& [ready, packet] = *waiting_.begin();
    return std::max(free_at_, ready) + (bytes_per_s_ > 0 ? double(packet.bytes) / bytes_per_s_ : 0);
}

void SlowLink::schedule() {
    loop_.cancel(timer_);
    timer_ = 0;
    if (!waiting_.empty())
        timer_ = loop_.after(std::max(0.0, first_due() - net::steady_seconds()), [this] { arrive(); });
}

void SlowLink::arrive() {
    const double now = net::steady_seconds();
    while (!waiting_.empty() && first_due() <= now) {
        free_at_ = first_due();
        const auto first = waiting_.extract(waiting_.begin());
        first.mapped().arrive();
    }
    schedule();
}

}  // namespace fetch
