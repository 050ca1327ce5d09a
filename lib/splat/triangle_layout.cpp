#include "splat/triangle_layout.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "splat/triangle_run.h"

namespace splat {

namespace {

// Blocks that are being filled with runs.
class BlockFiller {
  public:
    BlockFiller(std::vector<std::byte>& bytes, uint32_t block_size) : bytes_(bytes), block_size_(block_size) {
        begin_block();
    }

    uint64_t at() const { return bytes_.size(); }
    size_t room() const { return begin_ + block_size_ - bytes_.size(); }
    bool is_empty() const { return bytes_.size() == begin_ + kRunsAt; }
    void take(RunPacker& run) { run.finish(bytes_); }
    void next_block() { end_block(), begin_block(); }
    void end_block() {
        const TriangleBlockHeader head{0, uint32_t(bytes_.size() - begin_)};
        std::memcpy(bytes_.data() + begin_, &head, sizeof(head));
        bytes_.resize(begin_ + block_size_);
    }

  private:
    void begin_block() {
        begin_ = bytes_.size();
        bytes_.resize(begin_ + kRunsAt);
    }

    std::vector<std::byte>& bytes_;
    const uint32_t block_size_;
    size_t begin_ = 0;
};

}  // namespace

TriangleBlocks::TriangleBlocks(const TriangleSource& source, uint32_t block_size, uint64_t node_blocks,
                               const std::function<void(uint64_t, std::vector<uint32_t>&)>& leaves_of)
    : source_(source),
      block_size_(block_size),
      node_blocks_(node_blocks),
      chunks_((node_blocks + kChunk - 1) / kChunk) {
    core::parallel_for(chunks_.size(), [&](size_t c) {
        pack(c * kChunk, std::min(node_blocks, (c + 1) * kChunk), chunks_[c], leaves_of);
    });
    for (Chunk& chunk : chunks_) {
        chunk.first_block = count_;
        count_ += chunk.bytes.size() / block_size;
        source_.counts.smooth += chunk.smooth;
    }
}

uint64_t TriangleBlocks::at(uint64_t node_block) const {
    const Chunk& chunk = chunks_[node_block / kChunk];
    const uint64_t at = chunk.at[node_block % kChunk];
    return at == kNoLeaves ? 0 : (node_blocks_ + chunk.first_block) * block_size_ + at;
}

void TriangleBlocks::pack(uint64_t first, uint64_t end, Chunk& chunk,
                          const std::function<void(uint64_t, std::vector<uint32_t>&)>& leaves_of) const {
    const TriangleLeaves& leaves = source_.leaves;
    BlockFiller filler(chunk.bytes, block_size_);
    RunPacker run(leaves.lattice_bits);
    std::vector<uint32_t> numbers;
    for (uint64_t b = first; b < end; ++b) {
        numbers.clear();
        leaves_of(b, numbers);
        chunk.at.push_back(kNoLeaves);
        for (const uint32_t number : numbers) {
            const uint32_t triangle = source_.points[number].vertex;
            const glm::u32vec3 t = leaves.triangles[triangle];
            RunPacker::Corner corner[3];
            for (int k = 0; k < 3; ++k) corner[k] = {t[k], leaves.corners[t[k]], leaves.normals[t[k]]};
            const bool smooth = leaves.is_smooth[triangle];
            chunk.smooth += smooth;
            if (!run.add(corner, smooth, filler.room())) {
                // The run is full, or the block: then the next one has room.
                const bool is_full = run.is_full();
                if (!run.is_empty()) filler.take(run);
                if (!is_full || !run.add(corner, smooth, filler.room())) {
                    filler.next_block();
                    run.add(corner, smooth, filler.room());
                }
            }
            if (chunk.at.back() == kNoLeaves) chunk.at.back() = filler.at();
        }
        if (!run.is_empty()) filler.take(run);
    }
    if (filler.is_empty())
        chunk.bytes.resize(chunk.bytes.size() - kRunsAt);
    else
        filler.end_block();
    chunk.bytes.shrink_to_fit();
}

void TriangleBlocks::write(core::OutputFile& out) {
    core::parallel_for(chunks_.size(), [&](size_t c) {
        Chunk& chunk = chunks_[c];
        for (size_t b = 0; b < chunk.bytes.size() / block_size_; ++b) {
            const auto block = std::span(chunk.bytes).subspan(b * block_size_, block_size_);
            const uint32_t sum = block_checksum(block, node_blocks_ + chunk.first_block + b);
            std::memcpy(block.data(), &sum, sizeof(sum));
        }
    });
    for (const Chunk& chunk : chunks_) out.write(chunk.bytes);
}

}  // namespace splat
