// The table that this program is for: what was tried, what is promised, what was measured.
#pragma once

#include <string>

namespace stability {

// Adds a row, and fails the running test where `measured` is above `bound` (or is NaN).
void expect_at_most(const std::string& row, const std::string& quantity, double measured, double bound);

// Adds a row, and fails the running test where `measured` is below `bound` (or is NaN).
void expect_at_least(const std::string& row, const std::string& quantity, double measured, double bound);

}  // namespace stability
