#include "net/stop_signals.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cassert>
#include <cerrno>
#include <cstdint>

namespace net {

namespace {

std::atomic<int> asked_fd{-1};
static_assert(std::atomic<int>::is_always_lock_free);  // for the handler

void ask_to_stop(int) {
    const int error = errno;
    const uint64_t one = 1;
    // Fails only where it is full of earlier signals.
    static_cast<void>(!::write(asked_fd, &one, sizeof one));
    errno = error;
}

}  // namespace

StopSignals::StopSignals(EventLoop& loop) : loop_(loop), asked_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (!asked_) core::fail_with_errno("eventfd", "cannot be made");
    assert(asked_fd == -1);
    asked_fd = asked_.get();
    loop_.watch(asked_.get(), EPOLLIN, [this](uint32_t) { loop_.stop(); });
    struct sigaction action = {};
    action.sa_handler = ask_to_stop;
    action.sa_flags = SA_RESTART;
    for (size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &action, &before_[i]);
}

StopSignals::~StopSignals() {
    for (size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before_[i], nullptr);
    asked_fd = -1;
    loop_.unwatch(asked_.get());
}

}  // namespace net
