#include "net/stop_signals.h"

#include <pthread.h>
#include <sys/epoll.h>
#include <sys/signalfd.h>

namespace net {

StopSignals::StopSignals(EventLoop& loop) : loop_(loop) {
    sigset_t stops;
    sigemptyset(&stops);
    sigaddset(&stops, SIGTERM);
    sigaddset(&stops, SIGINT);
    signals_.reset(::signalfd(-1, &stops, SFD_NONBLOCK | SFD_CLOEXEC));
    if (!signals_) core::fail_with_errno("signalfd", "cannot be made");
    loop_.watch(signals_.get(), EPOLLIN, [this](uint32_t) {
        // Taken, or it would be delivered when signals are let through again.
        signalfd_siginfo taken;
        while (::read(signals_.get(), &taken, sizeof taken) > 0) {
        }
        loop_.stop();
    });
    ::pthread_sigmask(SIG_BLOCK, &stops, &before_);
}

StopSignals::~StopSignals() {
    loop_.unwatch(signals_.get());
    ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

}  // namespace net
