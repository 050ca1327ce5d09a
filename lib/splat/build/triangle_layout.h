// Laying triangle leaves out as runs, one after the other, in blocks of their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/file.h"
#include "splat/build/triangle_leaves.h"
#include "splat/format.h"

namespace splat {

// What is written of a model's leaves where they are triangles.
struct TriangleSource {
    const TriangleLeaves& leaves;
    std::span<const TreePoint> points;  // in tree order
    TriangleCounts& counts;             // smooth ones are counted
};

class TriangleBlocks {
  public:
    // Packs the leaves of each block of nodes, in the order of their slots; leaves_of(block, out) appends
    // their numbers in tree order.  In parallel.
    TriangleBlocks(const TriangleSource& source, uint32_t block_size, uint64_t node_blocks,
                   const std::function<void(uint64_t, std::vector<uint32_t>&)>& leaves_of);

    uint64_t count() const { return (size_ + payload_ - 1) / payload_; }
    // Where the first run of a node block's leaves is, as its header has it.
    uint64_t at(uint64_t node_block) const {
        const Chunk& chunk = chunks_[node_block / kChunk];
        const uint64_t at = chunk.at[node_block % kChunk];
        return at == kNoLeaves ? 0 : chunk.begin + at;
    }
    // The longest side of the middle one of its triangles, model units; 0 where it has none.
    float middle_side(uint64_t node_block) const {
        return chunks_[node_block / kChunk].middle_side[node_block % kChunk];
    }
    // Writes the blocks, once, behind those of the nodes.
    void write(core::OutputFile& out);

  private:
    // Runs of node blocks next to each other: so chunks are packed at once.
    struct Chunk {
        uint64_t begin = 0;  // among all runs' bytes
        std::vector<std::byte> bytes;
        std::vector<uint64_t> at;        // by node block, from the chunk's first byte; kNoLeaves
        std::vector<float> middle_side;  // likewise
        uint64_t smooth = 0;
    };
    static constexpr uint64_t kNoLeaves = ~uint64_t(0);
    static constexpr uint64_t kChunk = 64;

    void pack(uint64_t first, uint64_t end, Chunk& chunk,
              const std::function<void(uint64_t, std::vector<uint32_t>&)>& leaves_of) const;
    void fill(uint64_t number, std::span<std::byte> block) const;

    const TriangleSource source_;
    const uint32_t block_size_;
    const uint64_t payload_;  // bytes of a block that runs take
    const uint64_t node_blocks_;
    std::vector<Chunk> chunks_;
    uint64_t size_ = 0;  // of all runs
};

}  // namespace splat
