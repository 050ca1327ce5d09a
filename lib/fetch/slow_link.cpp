#include "fetch/slow_link.h"

#include <algorithm>

namespace fetch {

void SlowLink::pass(uint64_t bytes, std::function<void()> arrive) {
    if (!is_slow()) {
        arrive();
        return;
    }
    const double now = steady_seconds();
    free_at_ = std::max(free_at_, now + delay_s_) + (bytes_per_s_ > 0 ? double(bytes) / bytes_per_s_ : 0);
    packets_.push_back({free_at_, std::move(arrive)});
    if (timer_ == 0) timer_ = loop_.after(free_at_ - now, [this] { this->arrive(); });
}

void SlowLink::arrive() {
    timer_ = 0;
    const double now = steady_seconds();
    while (!packets_.empty() && packets_.front().due <= now) {
        const Packet packet = std::move(packets_.front());
        packets_.pop_front();
        packet.arrive();
    }
    if (!packets_.empty() && timer_ == 0)
        timer_ = loop_.after(packets_.front().due - now, [this] { this->arrive(); });
}

}  // namespace fetch
