// Zeroed memory of any size that costs what of it is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace core {

// Address space of `size` bytes, all 0, which takes memory page by page where it is written.  Move-only.
class AddressSpace {
  public:
    AddressSpace() = default;
    // Throws Error "<name>: ..." where the system has not that much room.
    AddressSpace(uint64_t size, const std::string& name);
    ~AddressSpace();
    AddressSpace(AddressSpace&& other) noexcept;
    AddressSpace& operator=(AddressSpace&& other) noexcept;

    std::span<std::byte> bytes() const { return bytes_; }

  private:
    std::span<std::byte> bytes_;
};

}  // namespace core
