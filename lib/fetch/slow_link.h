// A slow link for trying out: what comes passes one after the other at a rate (a bucket of tokens that holds
// none), and not before the round trips are over that it would have taken.
//
// These are: one for each answer; before it those in which its connection is set up, one for TCP and one for
// TLS; and those in which TCP starts slowly (RFC 6928: ten segments in the first round trip of a connection,
// and twice as many in each later one that was filled).  What a request takes on its way up is not counted.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <unordered_map>

#include "net/event_loop.h"

namespace fetch {

// Not thread-safe.  Without rate and round trip everything passes at once.
class SlowLink {
  public:
    // `bytes_per_s` 0: any rate.
    SlowLink(net::EventLoop& loop, double bytes_per_s, double round_trip_s)
        : loop_(loop), bytes_per_s_(bytes_per_s), round_trip_s_(round_trip_s) {}
    ~SlowLink() { loop_.cancel(timer_); }
    SlowLink(const SlowLink&) = delete;
    SlowLink& operator=(const SlowLink&) = delete;

    bool is_slow() const { return bytes_per_s_ > 0 || round_trip_s_ > 0; }
    // A connection has been made that takes so many round trips, in place of an earlier one of this number.
    void connect(long connection, int round_trips);
    double until_open_s(long connection) const;
    // Runs `arrive` when so many bytes of an answer, to a request that is sent now, have passed, after all
    // that passes on this connection before.
    void pass(long connection, uint64_t bytes, std::function<void()> arrive);

  private:
    struct Connection {
        double open_at = 0;               // when it has been set up
        double last = 0;                  // when what was passed last has made its round trips
        double round_began = 0;           // at the receiver
        double window = 0, in_round = 0;  // bytes in a round trip, allowed and so far
    };
    struct Packet {
        uint64_t bytes;
        std::function<void()> arrive;
    };
    double after_round_trips(Connection& connection, uint64_t bytes, double now) const;
    double first_due() const;
    void schedule();
    void arrive();

    net::EventLoop& loop_;
    double bytes_per_s_, round_trip_s_;
    double free_at_ = 0;                     // when the last packet has passed
    std::multimap<double, Packet> waiting_;  // by when they have made their round trips
    std::unordered_map<long, Connection> connections_;
    net::EventLoop::TimerId timer_ = 0;
};

}  // namespace fetch
