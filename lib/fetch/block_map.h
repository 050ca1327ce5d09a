// What a daemon and its clients share about a cached file: which blocks are there, and which are in use.
//
// Both are files that several processes map.  The availability map is written by the daemon alone: a page
// with MapHeader, then two bits a block, 32 blocks in a 64-bit word.  The use map is written by clients: a
// 32-bit time for each chunk of the data, when it was last read.
//
// How a reader and an eviction agree, though neither waits.  A reader writes the time of use, then looks
// whether the block is present.  The daemon marks a chunk's blocks absent, then looks at its time of use, and
// leaves the bytes where they are (and marks them present again) if that is younger than kGraceSeconds.  All
// of these are sequentially consistent, so that one of the two sees the other: a block that was seen present
// can be read for kGraceSeconds, and for longer if it is asked for again.
#pragma once

#include <time.h>

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace fetch {

enum class BlockState : uint64_t { absent = 0, wanted = 1, requested = 2, present = 3 };

constexpr uint32_t kBlockBytes = 1024;  // of an entry made now; fewest bytes to a given picture in simulation
constexpr uint32_t kChunkBytes = 65536;  // what is evicted at once: a multiple of file systems' blocks
constexpr uint32_t kGraceSeconds = 10;
// Blocks have 32-bit numbers, and no file that a stranger names may cost more than its map: 256 MiB.
constexpr uint64_t kMostFileBytes = uint64_t{1} << 40;

struct MapHeader {
    char magic[8];  // "qsfetch", 0
    uint32_t version;
    uint32_t block_bytes;
    uint64_t file_bytes;
    char boot_id[40];      // of the system whose page cache last held all that was written; see store.h
    uint32_t is_replaced;  // 1: the server has another version; the blocks that are here stay as they are
};
constexpr size_t kMapHeaderBytes = 4096;
static_assert(sizeof(MapHeader) <= kMapHeaderBytes);

constexpr uint64_t blocks_in(uint64_t file_bytes, uint32_t block_bytes) {
    return (file_bytes + block_bytes - 1) / block_bytes;
}
constexpr size_t map_bytes(uint64_t block_count) {
    return kMapHeaderBytes + size_t((block_count + 31) / 32 * 8);
}
constexpr size_t use_bytes(uint64_t file_bytes) {
    return size_t((file_bytes + kChunkBytes - 1) / kChunkBytes * sizeof(uint32_t));
}

// The two bits of each block, in a map that others read at the same time.
class BlockStates {
  public:
    BlockStates() = default;
    explicit BlockStates(std::byte* map) : words_(reinterpret_cast<uint64_t*>(map + kMapHeaderBytes)) {}

    BlockState get(uint32_t block) const {
        const uint64_t word = std::atomic_ref(words_[block / 32]).load(std::memory_order_seq_cst);
        return BlockState(word >> shift(block) & 3);
    }
    // For the daemon alone: two writers would lose each other's bits.
    void set(uint32_t block, BlockState state) const {
        const std::atomic_ref word(words_[block / 32]);
        const uint64_t others = word.load(std::memory_order_relaxed) & ~(uint64_t{3} << shift(block));
        word.store(others | uint64_t(state) << shift(block), std::memory_order_seq_cst);
    }

  private:
    static unsigned shift(uint32_t block) { return block % 32 * 2; }
    uint64_t* words_ = nullptr;
};

// The time that uses are told in: seconds since the system started, never 0, which means "not in use".
inline uint32_t use_clock() {
    timespec now = {};
    clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
    return uint32_t(now.tv_sec) + 1;
}

}  // namespace fetch
