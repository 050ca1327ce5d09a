// One thread that waits for descriptors and times, and runs what they are for.  Nothing to do costs nothing:
// it sleeps until a descriptor or the next time wakes it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <unordered_map>

#include "core/descriptor.h"

namespace net {

// Seconds of the steady clock, which jumps of the system's clock leave alone.
double steady_seconds();

// Not thread-safe.  Handlers may call anything here, for their own descriptors too.
class EventLoop {
  public:
    using Handler = std::function<void(uint32_t events)>;  // EPOLLIN, ... as epoll(7) has them
    using TimerId = uint64_t;                              // never 0

    EventLoop();

    // Takes the place of an earlier watch on the same descriptor.
    void watch(int fd, uint32_t events, Handler handler);
    void change(int fd, uint32_t events);
    void unwatch(int fd);  // before the descriptor is closed

    TimerId after(double seconds, std::function<void()> run);
    void cancel(TimerId timer);  // nothing for one that has run

    void run();  // until stop()
    void stop() { is_stopped_ = true; }

  private:
    struct Watch {
        uint64_t tag;
        Handler handler;
    };
    struct Timer {
        TimerId id;
        std::function<void()> run;
    };
    void run_timers();
    int wait_ms() const;

    core::Descriptor epoll_;
    // By descriptor; a tag tells a watch from an earlier one of a descriptor with the same number.
    std::unordered_map<int, std::shared_ptr<Watch>> watches_;
    std::multimap<double, Timer> timers_;
    std::unordered_map<TimerId, double> times_;
    uint64_t next_tag_ = 1;
    TimerId next_timer_ = 1;
    bool is_stopped_ = false;
};

}  // namespace net
