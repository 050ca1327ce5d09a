// Owned file descriptors and maps of files, and errors of the system as sentences.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "core/error.h"

namespace fetch {

// The disk, or the user's share of it, has no space left.
class DiskFull : public core::Error {
  public:
    using core::Error::Error;
};

// Throws core::Error (DiskFull where that is the reason) "<name>: <what>: <reason of errno>".
[[noreturn]] inline void fail_with_errno(const std::string& name, const char* what) {
    const int reason = errno;
    const std::string sentence = name + ": " + what + ": " + std::strerror(reason);
    if (reason == ENOSPC || reason == EDQUOT) throw DiskFull(sentence);
    throw core::Error(sentence);
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

// A shared map of the first `size` bytes of a file.  The file must be that long, and stay so: one that
// shrinks ends the program by SIGBUS, as with any map.
class FileMap {
  public:
    FileMap() = default;
    // Throws core::Error, in which `name` is the file.
    FileMap(int fd, size_t size, bool is_writable, const std::string& name) : size_(size) {
        if (size == 0) return;
        void* const at =
            ::mmap(nullptr, size, is_writable ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED, fd, 0);
        if (at == MAP_FAILED) fail_with_errno(name, "cannot map");
        data_ = static_cast<std::byte*>(at);
    }
    ~FileMap() {
        if (data_) ::munmap(data_, size_);
    }
    FileMap(FileMap&& other) noexcept
        : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
    FileMap& operator=(FileMap&& other) noexcept {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        return *this;
    }
    std::byte* data() const { return data_; }
    size_t size() const { return size_; }

  private:
    std::byte* data_ = nullptr;
    size_t size_ = 0;
};

}  // namespace fetch
