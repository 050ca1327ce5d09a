// What programs say beside their results: lines on standard error, progress, data for people on standard
// output.
//
// Apart from program.h, which these belong to, because that takes the option parser with it: seconds of
// compiling for every file that includes it.  Program says whose name stands before the lines and what
// --quiet, --verbose and --progress ask for.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace core {

// Lines on standard error, "name: warning: sentence".  notice() shows with --verbose only;
// nothing but errors with --quiet.
void warn(const std::string& sentence);
void notice(const std::string& sentence);

// --quiet was given: a table for people is not wanted either.
bool is_quiet();

// Reports a failed operand ("name: sentence") and makes run() return 1 at the end, so that the
// other operands are still done.
void fail(const std::string& sentence);

// One line, redrawn at most 10 times a second, erased at the end; drawn where standard error is a
// terminal, or as --progress auto|always|never says.  update() may be called from any thread.
class Progress {
  public:
    Progress(std::string what, uint64_t total);  // total 0: unknown
    ~Progress();
    void update(uint64_t done);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

// Writes to standard output (data for people or scripts); checked at the end of run().
void print(std::string_view text);

}  // namespace core
