// A model file that exists in memory only: opened, and changed so that its checksums hold.
#pragma once

#include <sys/mman.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "core/file.h"
#include "require.h"
#include "splat/format.h"

using Bytes = std::vector<std::byte>;

inline core::InputFile memory_file(const Bytes& bytes) {
    const int fd = ::memfd_create("model", 0);
    require(fd >= 0, "a file in memory opens");
    for (size_t done = 0; done < bytes.size();) {
        const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
        require(n > 0, "a file in memory takes the bytes");
        done += size_t(n);
    }
    core::InputFile file("/proc/self/fd/" + std::to_string(fd));
    ::close(fd);
    return file;
}

inline void repair_header(std::span<std::byte> bytes) {
    const uint64_t sum = XXH3_64bits(bytes.data(), splat::kHeaderSize - 8);
    std::memcpy(bytes.data() + splat::kHeaderSize - 8, &sum, 8);
}

// Of the two headers and the tables; pages and blocks have theirs still.
inline void repair_coded(Bytes& bytes) {
    if (bytes.size() < splat::kCodedHeaderSize + splat::kHeaderSize) return;
    repair_header(std::span(bytes).subspan(splat::kCodedHeaderSize, splat::kHeaderSize));
    uint32_t tables;
    std::memcpy(&tables, bytes.data() + 12, 4);
    const uint64_t at = splat::kCodedHeaderSize + splat::kHeaderSize + uint64_t(tables);
    if (at + 8 > bytes.size()) return;
    const uint64_t sum = XXH3_64bits(bytes.data(), at);
    std::memcpy(bytes.data() + at, &sum, 8);
}

// Sets the checksums of the header and of whole blocks right, and the gap between them to 0, so that other
// checks are reached.
inline void repair_checksums(Bytes& bytes) {
    if (splat::is_coded(bytes)) return repair_coded(bytes);
    if (bytes.size() < splat::kHeaderSize) return;
    repair_header(bytes);
    std::fill(bytes.begin() + splat::kHeaderSize,
              bytes.begin() + ptrdiff_t(std::min(bytes.size(), splat::kBlocksAt)), std::byte{0});
    uint32_t block_size;
    std::memcpy(&block_size, bytes.data() + 16, 4);
    if (block_size < splat::kMinBlockSize || block_size > splat::kMaxBlockSize) return;
    for (uint64_t b = 0; splat::kBlocksAt + (b + 1) * block_size <= bytes.size(); ++b) {
        const std::span<std::byte> block =
            std::span(bytes).subspan(splat::kBlocksAt + b * block_size, block_size);
        const uint32_t sum = splat::block_checksum(block, b);
        std::memcpy(block.data(), &sum, 4);
    }
}
