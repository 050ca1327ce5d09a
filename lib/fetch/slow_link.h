// A slow link for trying out: what comes passes one after the other at a rate, each after a delay.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>

#include "fetch/event_loop.h"

namespace fetch {

// Not thread-safe.  Without rate and delay everything passes at once.
class SlowLink {
  public:
    // `bytes_per_s` 0: any rate.  `delay_s`: added to each answer, which is what a longer round trip does.
    SlowLink(EventLoop& loop, double bytes_per_s, double delay_s)
        : loop_(loop), bytes_per_s_(bytes_per_s), delay_s_(delay_s) {}
    ~SlowLink() { loop_.cancel(timer_); }
    SlowLink(const SlowLink&) = delete;
    SlowLink& operator=(const SlowLink&) = delete;

    bool is_slow() const { return bytes_per_s_ > 0 || delay_s_ > 0; }
    // Runs `arrive` when so many bytes have passed, after all that was passed before.
    void pass(uint64_t bytes, std::function<void()> arrive);

  private:
    struct Packet {
        double due;
        std::function<void()> arrive;
    };
    void arrive();

    EventLoop& loop_;
    double bytes_per_s_, delay_s_;
    double free_at_ = 0;  // when the last packet has passed
    std::deque<Packet> packets_;
    EventLoop::TimerId timer_ = 0;
};

}  // namespace fetch
