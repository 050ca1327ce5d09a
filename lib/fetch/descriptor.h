// Descriptors and maps of the files that the store, the daemon and its clients share.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <string>
#include <utility>

#include "core/descriptor.h"

namespace fetch {

using core::Descriptor;
using core::DiskFull;
using core::fail_with_errno;

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
