// The two kinds of failure, for all of the project.  A message is one complete sentence
// without full stop, "file: place: what is wrong", lower case; the program's name is put
// before it where it is printed.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace core {

// The job failed: input, network or disk.  Exit status 1.
class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// The command line was wrong; nothing was touched.  Exit status 2.
class UsageError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// printf into a string.  The C locale is never changed, so numbers have a point.
[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...);

// What is wrong with a file's bytes that have another checksum, of so many hexadecimal digits, than is stored
// beside them, and what to do.
std::string wrong_checksum(uint64_t found, uint64_t stored, int digits);

}  // namespace core
