// SIGTERM and SIGINT stop an event loop between two events, so that a server ends cleanly.
#pragma once

#include <signal.h>

#include <array>

#include "core/descriptor.h"
#include "net/event_loop.h"

namespace net {

// From its making to its end, whichever thread the system gives the signals to: those that were started
// before, as the ones that share out loops, let them through.  One at a time in a process; `loop` outlives
// it.
class StopSignals {
  public:
    explicit StopSignals(EventLoop& loop);
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

  private:
    static constexpr std::array kSignals{SIGTERM, SIGINT};

    EventLoop& loop_;
    core::Descriptor asked_;  // an eventfd, written by the handler
    std::array<struct sigaction, kSignals.size()> before_ = {};
};

}  // namespace net
