// How fast something counts, over the last while.
#pragma once

#include <deque>

namespace view {

class Meter {
  public:
    explicit Meter(double window_s = 1) : window_s_(window_s) {}

    // A count that only grows; one that is less than before begins anew.
    void note(double count, double time_s) {
        if (!notes_.empty() && count < notes_.back().count) notes_.clear();
        notes_.push_back({count, time_s});
        forget(time_s);
    }
    // By second, up to now; 0 where less than two notes are young enough.
    double rate(double time_s) {
        forget(time_s);
        if (notes_.size() < 2) return 0;
        const double passed_s = notes_.back().time_s - notes_.front().time_s;
        return passed_s > 0 ? (notes_.back().count - notes_.front().count) / passed_s : 0;
    }

  private:
    struct Note {
        double count, time_s;
    };
    void forget(double time_s) {
        while (!notes_.empty() && notes_.front().time_s < time_s - window_s_) notes_.pop_front();
    }

    double window_s_;
    std::deque<Note> notes_;
};

}  // namespace view
