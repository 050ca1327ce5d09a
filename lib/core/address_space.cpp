#include "core/address_space.h"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/error.h"

namespace core {

AddressSpace::AddressSpace(uint64_t size, const std::string& name) {
    if (size == 0) return;
    void* map =
        ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (map == MAP_FAILED)
        throw Error(text("%s: cannot have %llu bytes of address space: %s", name.c_str(),
                         static_cast<unsigned long long>(size), std::strerror(errno)));
    bytes_ = {static_cast<std::byte*>(map), size};
}

AddressSpace::~AddressSpace() {
    if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

AddressSpace::AddressSpace(AddressSpace&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

AddressSpace& AddressSpace::operator=(AddressSpace&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
}

}  // namespace core
