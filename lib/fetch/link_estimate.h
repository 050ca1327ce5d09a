// How much to have in flight to one server: an estimate of bandwidth and round trip from what arrives.
//
// About 1.5 products of the two: half a product loses 43 % of the throughput, eight delay the first useful
// block after a change of view by up to 1.2 s (in simulation, 384 kbit/s, 150 ms).  As with BBR (Cardwell et
// al., 2016) the bandwidth is the largest rate of late, and the round trip the smallest: what is in flight
// then grows by itself until the rate does not follow any more; at the start it doubles in every round trip.
// A rate says what the link can carry only where the window was full, or answers waited behind each other:
// one that was not, for want of blocks or of connections, is no reason to believe less of the link than
// before, or to end the start.  (Without that six connections with requests of 2 KiB each kept themselves at
// 0.6 of 8 Mbit/s at 150 ms.) On a link that is kept full an answer waits behind those before it, so that no
// round trip is seen: every 10 s half a product is left in flight until one is.  (Without that the window
// grew by a half every 10 s.)
//
// Bytes are those on the wire: to a slow link the header of an answer is a quarter of a block.  On such a
// link the product and one more block are enough, however short the way is.  (With three blocks at least, and
// bodies alone counted, a new view's first block came after 163 ms instead of 114 at 384 kbit/s and 40 ms.)
#pragma once

#include <cstdint>
#include <deque>

namespace fetch {

// Times are seconds of any steady clock, which do not decrease from call to call.
class LinkEstimate {
  public:
    void request_sent(double now, uint64_t bytes);  // of the body
    // An answer's header came, so long after the request was on its way.
    void answer_began(double now, double after_s, uint64_t header_bytes);
    void bytes_came(double now, uint64_t bytes);
    // The request is over; so many of its bytes did not come, nor the header perhaps.
    void request_ended(double now, uint64_t missing, bool has_begun);

    // So many will be used, over which requests are spread.
    void set_connections(unsigned connections) { connections_ = connections; }

    // There is room in the window, and nothing to fill it with, or no connection for it.
    void left_unfilled() { unfilled_windows_ = 2; }

    uint64_t in_flight_bytes() const { return in_flight_ + headers_in_flight_ * header_bytes_; }
    // A request may be sent while less than so much is in flight; one that nobody waits for, while less than
    // fills the link: then no other waits behind it.
    uint64_t window_bytes() const;
    uint64_t idle_window_bytes() const;
    // The most bytes of a body that one request should ask for, when `streams` run at a time; and how many it
    // takes at least for these to fill the window.
    uint64_t request_bytes(unsigned streams) const;
    uint64_t share_bytes(unsigned streams) const { return window_bytes() / streams; }
    // How alike neighbours must be to be joined, as a factor of the priority.
    float join_factor() const;

    double bytes_per_s() const { return rate_; }  // 0: not known yet
    double round_trip_s() const;                  // 0: not known yet

  private:
    struct Sample {
        double at, value;
    };
    double product_s() const;
    double full_bytes() const;
    void land(double now, uint64_t bytes);
    double busy_s(double now) const;
    void end_window(double now);
    void note_drained(double now);
    void note_start(double now, uint64_t bytes);
    double start_window() const;
    bool is_start() const;

    uint64_t in_flight_ = 0;          // of bodies
    uint64_t headers_in_flight_ = 0;  // how many
    uint64_t header_bytes_ = 0;       // of the last one
    double rate_ = 0;
    std::deque<Sample> rates_, round_trips_;  // of late; the extreme one first
    bool is_probing_ = false;                 // for a round trip
    double drained_at_ = -1;                  // of a probe: since when there is little in flight; -1: not yet
    // A rate is taken over a window of time in which something was in flight; pauses do not count.
    double busy_since_ = 0, busy_before_ = 0;
    uint64_t window_bytes_came_ = 0;
    int unfilled_windows_ = 0;      // this one and the next, in which the answers come to what was sent in it
    bool has_queued_ = false;       // in this one an answer waited behind others
    double best_rate_ = 0;          // since the start
    int windows_without_gain_ = 0;  // at the start
    // At the start the window is that of TCP on all connections, which grows by what comes, on links on which
    // the first bytes, once they came, came fast: a rate over whole round trips says little while most of
    // each is spent waiting.
    unsigned connections_ = 1;
    double start_bytes_ = 0, burst_began_ = -1, burst_bytes_ = 0, burst_rate_ = 0;
};

}  // namespace fetch
