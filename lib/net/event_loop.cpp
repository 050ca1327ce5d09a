#include "net/event_loop.h"

#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace net {

double steady_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

EventLoop::EventLoop() : epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
    if (!epoll_) core::fail_with_errno("epoll", "cannot be made");
}

namespace {

// A descriptor and a tag in the 64 bits that epoll keeps.
uint64_t packed(int fd, uint64_t tag) {
    return tag << 32 | uint32_t(fd);
}

}  // namespace

void EventLoop::watch(int fd, uint32_t events, Handler handler) {
    const uint64_t tag = next_tag_++ & 0xffffffff;
    epoll_event event = {};
    event.events = events;
    event.data.u64 = packed(fd, tag);
    // A descriptor that was closed under its watch is unknown to epoll, and may have come back.
    const bool is_changed =
        watches_.contains(fd) && ::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, fd, &event) == 0;
    if (!is_changed && ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) != 0)
        core::fail_with_errno("epoll", "cannot watch");
    watches_[fd] = std::make_shared<Watch>(tag, std::move(handler));
}

void EventLoop::change(int fd, uint32_t events) {
    epoll_event event = {};
    event.events = events;
    event.data.u64 = packed(fd, watches_.at(fd)->tag);
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, fd, &event) != 0)
        core::fail_with_errno("epoll", "cannot watch");
}

void EventLoop::unwatch(int fd) {
    if (watches_.erase(fd) > 0) ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, fd, nullptr);
}

EventLoop::TimerId EventLoop::after(double seconds, std::function<void()> run) {
    const TimerId id = next_timer_++;
    const double time = steady_seconds() + seconds;
    timers_.emplace(time, Timer{id, std::move(run)});
    times_[id] = time;
    return id;
}

void EventLoop::cancel(TimerId timer) {
    const auto time = times_.find(timer);
    if (time == times_.end()) return;
    const auto [begin, end] = timers_.equal_range(time->second);
    timers_.erase(std::find_if(begin, end, [&](const auto& entry) { return entry.second.id == timer; }));
    times_.erase(time);
}

// Those that are due now; what they start with no delay comes after the descriptors have had their turn.
void EventLoop::run_timers() {
    const double now = steady_seconds();
    while (!timers_.empty() && timers_.begin()->first <= now && !is_stopped_) {
        const Timer timer = std::move(timers_.begin()->second);
        timers_.erase(timers_.begin());
        times_.erase(timer.id);
        timer.run();
    }
}

int EventLoop::wait_ms() const {
    if (timers_.empty()) return -1;
    const double ms = std::ceil((timers_.begin()->first - steady_seconds()) * 1000);
    return int(std::clamp(ms, 0.0, 3'600'000.0));
}

void EventLoop::run() {
    std::array<epoll_event, 256> events;
    while (!is_stopped_) {
        const int count = ::epoll_wait(epoll_.get(), events.data(), int(events.size()), wait_ms());
        if (count < 0 && errno != EINTR) core::fail_with_errno("epoll", "cannot wait");
        for (int i = 0; i < count && !is_stopped_; ++i) {
            const int fd = int(uint32_t(events[size_t(i)].data.u64));
            const auto found = watches_.find(fd);
            if (found == watches_.end() || packed(fd, found->second->tag) != events[size_t(i)].data.u64)
                continue;
            // The handler may unwatch itself.
            const std::shared_ptr<Watch> watch = found->second;
            watch->handler(events[size_t(i)].events);
        }
        run_timers();
    }
}

}  // namespace net
