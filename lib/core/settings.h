// What the common options of a program said, for the functions of core that have no Program at hand.  Written
// by Program before the job starts, read by any thread after.  Of no interest outside lib/core.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace core {

struct Settings {
    std::string program = "qs";
    std::string progress = "auto";
    std::string report;
    int64_t threads = 0;
    bool quiet = false;
    bool verbose = false;
};
extern Settings settings;

// Set by fail(); run() then returns 1.
extern std::atomic<bool> has_failed;

// "name: line" on standard error, whole.
void say(const std::string& line);

}  // namespace core
