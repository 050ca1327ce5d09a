// Times of stages, for reports.
#pragma once

#include <time.h>

#include <chrono>

namespace core {

// Runs from its making on.
class Stopwatch {
  public:
    // Milliseconds since the last lap (or the making).
    double lap_ms() {
        const auto now = std::chrono::steady_clock::now();
        const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
        last_ = now;
        return ms;
    }

  private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// The same in processor time of the thread that asks, whatever else the machine does meanwhile.
class ProcessorWatch {
  public:
    double lap_ms() {
        const double at = now_ms(), ms = at - last_;
        last_ = at;
        return ms;
    }

  private:
    static double now_ms() {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return 1e3 * double(t.tv_sec) + 1e-6 * double(t.tv_nsec);
    }
    double last_ = now_ms();
};

}  // namespace core
