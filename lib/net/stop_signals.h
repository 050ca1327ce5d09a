// SIGTERM and SIGINT stop an event loop between two events, so that a server ends cleanly.
#pragma once

#include <signal.h>

#include "core/descriptor.h"
#include "net/event_loop.h"

namespace net {

// From its making to its end the two signals are blocked in the calling thread, and in those that it starts
// then; `loop` outlives it.
class StopSignals {
  public:
    explicit StopSignals(EventLoop& loop);
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

  private:
    EventLoop& loop_;
    core::Descriptor signals_;
    sigset_t before_ = {};
};

}  // namespace net
