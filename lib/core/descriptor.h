// Owned file descriptors, and errors of the system as sentences.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "core/error.h"

namespace core {

// The disk, or the user's share of it, has no space left.
class DiskFull : public Error {
  public:
    using Error::Error;
};

// Throws Error (DiskFull where that is the reason) "<name>: <what>: <reason of errno>".
[[noreturn]] inline void fail_with_errno(const std::string& name, const char* what) {
    const int reason = errno;
    const std::string sentence = name + ": " + what + ": " + std::strerror(reason);
    if (reason == ENOSPC || reason == EDQUOT) throw DiskFull(sentence);
    throw Error(sentence);
}

class Descriptor {
  public:
    explicit Descriptor(int value = -1) : value_(value) {}
    ~Descriptor() { reset(); }
    Descriptor(Descriptor&& other) noexcept : value_(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        if (this != &other) reset(other.release());
        return *this;
    }
    int get() const { return value_; }
    explicit operator bool() const { return value_ >= 0; }
    int release() { return std::exchange(value_, -1); }
    void reset(int value = -1) {
        if (value_ >= 0) ::close(value_);
        value_ = value;
    }

  private:
    int value_;
};

}  // namespace core
