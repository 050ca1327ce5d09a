// A bounds-checked little-endian view of bytes from outside.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"

namespace core {

static_assert(std::endian::native == std::endian::little, "only little-endian hosts are supported");

// Reads values in turn.  Throws Error "<name>: cut off at byte N" where bytes are missing.
class ByteReader {
  public:
    ByteReader(std::span<const std::byte> bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

    template <class T>
    T take() {
        if (bytes_.size() - at_ < sizeof(T))
            throw Error(text("%s: cut off at byte %zu", name_.c_str(), bytes_.size()));
        T value;
        std::memcpy(&value, bytes_.data() + at_, sizeof(T));
        at_ += sizeof(T);
        return value;
    }
    size_t position() const { return at_; }

  private:
    std::span<const std::byte> bytes_;
    std::string name_;
    size_t at_ = 0;
};

// Appends values to a growing buffer.
class ByteWriter {
  public:
    template <class T>
    void put(T value) {
        const size_t at = bytes.size();
        bytes.resize(at + sizeof(T));
        std::memcpy(bytes.data() + at, &value, sizeof(T));
    }
    std::vector<std::byte> bytes;
};

}  // namespace core
