#include "fetch/link_estimate.h"

#include <algorithm>

#include "fetch/block_map.h"

namespace fetch {

namespace {

constexpr double kProducts = 1.5, kProductsAtStart = 2.5, kProductsOfProbe = 0.5;
constexpr double kFirstSegments = 10 * 1460;  // of a TCP connection, in its first round trip (RFC 6928)
// Bytes of these that tell how fast a link carries them, more or less.
constexpr double kBurst = 8 * 1024, kLeastBurst = 2 * 1024;
constexpr double kShortestBurst = 1e-4;  // seconds
constexpr double kQueued = 1.5;          // round trips until an answer comes that waits behind others
constexpr double kGain = 1.25;           // in one window; a link whose rate grows less, three times, is full
constexpr int kWindowsAtStart = 3;
constexpr double kRateMemory = 1.0, kRoundTripMemory = 10.0;  // seconds
constexpr double kShortestWindow = 0.002;                     // below that, a rate is noise
constexpr uint64_t kLeastWindow = 8 * 1024;                   // bytes; and of fewer
constexpr double kUnknown = 3 * 1024;                         // in flight, while nothing is known of a link
constexpr uint64_t kJoined = 16 * 1024;                       // the order is kept up to here
// Two requests that are under way, and then the first block of a new view, come within 1.5 round trips and
// 100 ms.
constexpr double kMostSecondsARequest = 0.04, kMostRoundTripsARequest = 0.25;
// On a fast link requests cost more than order: 10 ms of it are a delay that nobody sees.
constexpr double kFewSecondsARequest = 0.01;
constexpr uint64_t kMostRequest = 1 << 20;
constexpr double kFast = 50e6 / 8;
// What wakes up a process and a server takes a fraction of a millisecond, on a link of any speed.
constexpr double kShortestProduct = 0.002;

}  // namespace

void LinkEstimate::request_sent(double now, uint64_t bytes) {
    if (in_flight_ == 0) {
        busy_since_ = now;
        if (burst_bytes_ < kBurst) burst_began_ = -1, burst_bytes_ = 0;
    }
    in_flight_ += bytes;
    ++headers_in_flight_;
}

void LinkEstimate::land(double now, uint64_t bytes) {
    if (in_flight_ == 0) return;
    in_flight_ -= std::min(in_flight_, bytes);
    if (in_flight_ == 0) busy_before_ += now - busy_since_;
    note_drained(now);
}

void LinkEstimate::note_drained(double now) {
    if (is_probing_ && drained_at_ < 0 && in_flight_bytes() <= window_bytes()) drained_at_ = now;
}

double LinkEstimate::busy_s(double now) const {
    return busy_before_ + (in_flight_ > 0 ? now - busy_since_ : 0);
}

void LinkEstimate::answer_began(double now, double after_s, uint64_t header_bytes) {
    if (headers_in_flight_ > 0) --headers_in_flight_;
    header_bytes_ = header_bytes;
    window_bytes_came_ += header_bytes;
    if (burst_began_ < 0) burst_began_ = now;
    note_drained(now);
    if (!round_trips_.empty() && after_s > kQueued * round_trip_s()) has_queued_ = true;
    const bool ends_probe = is_probing_ && drained_at_ >= 0 && now - after_s >= drained_at_;
    if (ends_probe) {
        round_trips_.clear();
        is_probing_ = false;
    }
    while (!round_trips_.empty() && round_trips_.back().value >= after_s) round_trips_.pop_back();
    round_trips_.push_back({now, after_s});
    if (is_probing_ || round_trips_.front().at >= now - kRoundTripMemory) return;
    is_probing_ = true;
    drained_at_ = -1;
    note_drained(now);
}

bool LinkEstimate::is_start() const {
    return windows_without_gain_ < kWindowsAtStart;
}

void LinkEstimate::note_start(double now, uint64_t bytes) {
    start_bytes_ += double(bytes);
    if (burst_bytes_ >= kBurst) return;
    burst_bytes_ += double(bytes);
    if (burst_bytes_ >= kLeastBurst)
        burst_rate_ = burst_bytes_ / std::max(kShortestBurst, now - burst_began_);
}

double LinkEstimate::start_window() const {
    const double of_tcp = connections_ * kFirstSegments + start_bytes_;
    return std::min(of_tcp, kProductsAtStart * burst_rate_ * product_s());
}

void LinkEstimate::bytes_came(double now, uint64_t bytes) {
    if (is_start()) note_start(now, bytes);
    land(now, bytes);
    window_bytes_came_ += bytes;
    if (busy_s(now) >= std::max(kShortestWindow, round_trip_s()) && window_bytes_came_ >= kLeastWindow)
        end_window(now);
}

void LinkEstimate::request_ended(double now, uint64_t missing, bool has_begun) {
    if (!has_begun && headers_in_flight_ > 0) --headers_in_flight_;
    land(now, missing);
}

void LinkEstimate::end_window(double now) {
    const double rate = double(window_bytes_came_) / busy_s(now);
    const bool was_full = unfilled_windows_ == 0 || has_queued_;
    if (unfilled_windows_ > 0) --unfilled_windows_;
    has_queued_ = false;
    if (was_full || rate >= rate_) {
        while (!rates_.empty() && rates_.back().value <= rate) rates_.pop_back();
        rates_.push_back({now, rate});
        while (rates_.front().at < now - kRateMemory) rates_.pop_front();
        rate_ = rates_.front().value;
    }
    if (is_start()) {
        if (rate > kGain * best_rate_)
            windows_without_gain_ = 0;
        else if (was_full)
            ++windows_without_gain_;
        best_rate_ = std::max(best_rate_, rate);
    }
    busy_since_ = now;
    busy_before_ = 0;
    window_bytes_came_ = 0;
}

double LinkEstimate::round_trip_s() const {
    return round_trips_.empty() ? 0 : round_trips_.front().value;
}

double LinkEstimate::product_s() const {
    return std::max(round_trip_s(), kShortestProduct);
}

uint64_t LinkEstimate::window_bytes() const {
    if (is_probing_) return uint64_t(kProductsOfProbe * rate_ * product_s());
    double window = (is_start() ? kProductsAtStart : kProducts) * rate_ * product_s();
    if (is_start()) window = std::max(window, start_window());
    return uint64_t(std::max(full_bytes(), window));
}

// One block is on its way to us while the next one's request is on its way to the server.
double LinkEstimate::full_bytes() const {
    return rate_ > 0 ? rate_ * product_s() + double(kBlockBytes + header_bytes_) : kUnknown;
}

uint64_t LinkEstimate::idle_window_bytes() const {
    return is_start() ? window_bytes() : std::min(window_bytes(), uint64_t(full_bytes()));
}

uint64_t LinkEstimate::request_bytes(unsigned streams) const {
    const auto share = double(share_bytes(streams));
    const double few = std::max({double(kJoined), kFewSecondsARequest * rate_, share});
    const double longest = (kMostSecondsARequest + kMostRoundTripsARequest * round_trip_s()) * rate_;
    return std::min(kMostRequest, uint64_t(std::min(few, std::max(longest - double(header_bytes_), share))));
}

float LinkEstimate::join_factor() const {
    return rate_ > kFast ? 0.1f : 0.3f;
}

}  // namespace fetch
