#include "splat/build/triangle_layout.h"

#include <algorithm>
#include <cstring>

#include "core/parallel.h"
#include "splat/build/run_packer.h"
#include "splat/triangle_sizes.h"

namespace splat {

TriangleBlocks::TriangleBlocks(const TriangleSource& source, uint32_t block_size, uint64_t node_blocks,
                               const std::function<void(uint64_t, std::vector<uint32_t>&)>& leaves_of)
    : source_(source),
      block_size_(block_size),
      payload_(block_size - kTriangleBlockHeader),
      node_blocks_(node_blocks),
      chunks_((node_blocks + kChunk - 1) / kChunk) {
    core::parallel_for(chunks_.size(), [&](size_t c) {
        pack(c * kChunk, std::min(node_blocks, (c + 1) * kChunk), chunks_[c], leaves_of);
    });
    for (Chunk& chunk : chunks_) {
        chunk.begin = size_;
        size_ += chunk.bytes.size();
        source_.counts.smooth += chunk.smooth;
    }
}

void TriangleBlocks::pack(uint64_t first, uint64_t end, Chunk& chunk,
                          const std::function<void(uint64_t, std::vector<uint32_t>&)>& leaves_of) const {
    const TriangleLeaves& leaves = source_.leaves;
    RunPacker run(leaves.lattice_bits);
    TriangleSizes sizes;
    std::vector<uint32_t> numbers;
    for (uint64_t b = first; b < end; ++b) {
        numbers.clear();
        leaves_of(b, numbers);
        chunk.at.push_back(numbers.empty() ? kNoLeaves : chunk.bytes.size());
        for (const uint32_t number : numbers) {
            const uint32_t triangle = source_.points[number].vertex;
            const glm::u32vec3 t = leaves.triangles[triangle];
            RunPacker::Corner corner[3];
            for (int k = 0; k < 3; ++k) corner[k] = {t[k], leaves.corners[t[k]], leaves.normals[t[k]]};
            if (run.is_full()) run.finish(chunk.bytes);
            sizes.add(corner[0].position, corner[1].position, corner[2].position);
            run.add(corner, leaves.is_smooth[triangle]);
            chunk.smooth += leaves.is_smooth[triangle];
        }
        if (!run.is_empty()) run.finish(chunk.bytes);
        chunk.middle_side.push_back(sizes.empty() ? 0 : sizes.take_middle(leaves.step));
    }
    chunk.bytes.shrink_to_fit();
}

void TriangleBlocks::fill(uint64_t number, std::span<std::byte> block) const {
    const uint64_t begin = number * payload_, end = std::min(size_, begin + payload_);
    auto chunk = std::upper_bound(chunks_.begin(), chunks_.end(), begin,
                                  [](uint64_t at, const Chunk& c) { return at < c.begin; }) -
                 1;
    for (uint64_t at = begin; at < end; ++chunk) {
        const uint64_t from = at - chunk->begin, count = std::min(end - at, chunk->bytes.size() - from);
        std::memcpy(block.data() + kTriangleBlockHeader + (at - begin), chunk->bytes.data() + from, count);
        at += count;
    }
    const uint32_t sum = block_checksum(block, node_blocks_ + number);
    std::memcpy(block.data(), &sum, sizeof(sum));
}

void TriangleBlocks::write(core::OutputFile& out) {
    constexpr uint64_t kBatch = 4096;  // blocks held in memory
    std::vector<std::byte> bytes;
    for (uint64_t first = 0; first < count(); first += kBatch) {
        const uint64_t batch = std::min(kBatch, count() - first);
        bytes.assign(batch * block_size_, std::byte{0});
        core::parallel_for(
            batch, [&](size_t b) { fill(first + b, std::span(bytes).subspan(b * block_size_, block_size_)); },
            64);
        out.write(bytes);
    }
}

}  // namespace splat
