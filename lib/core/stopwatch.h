// Times of stages, for reports.
#pragma once

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

}  // namespace core
