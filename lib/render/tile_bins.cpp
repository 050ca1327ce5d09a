#include "render/tile_bins.h"

#include <utility>

namespace render {

ChunkStore::Slab* ChunkStore::take() {
    const std::scoped_lock lock(mutex_);
    // Not cleared: the colours of splats without any then never take memory.
    if (taken_ == slabs_.size()) slabs_.push_back(std::make_unique_for_overwrite<Slab>());
    return slabs_[taken_++].get();
}

void TileBins::begin(int tiles_across, int tiles_down) {
    tiles_across_ = tiles_across;
    bins_.assign(size_t(tiles_across) * size_t(tiles_down), Bin{});
    used_.clear();
    slab_ = nullptr;
    chunks_taken_ = ChunkStore::kSlab;
}

void TileBins::refill(uint32_t tile, Bin& bin, std::vector<TileRun>& runs) {
    if (bin.chunk)
        runs.push_back({tile, bin.count, bin.chunk, bin.colours});
    else
        used_.push_back(tile);
    if (chunks_taken_ == ChunkStore::kSlab) slab_ = store_.take(), chunks_taken_ = 0;
    bin = {&slab_->chunks[chunks_taken_], &slab_->colours[chunks_taken_], 0};
    ++chunks_taken_;
    // Its lines are the last frame's and far away by now: ask for all before the first is written.
    constexpr uint32_t kLine = 16;
    for (uint32_t at = 0; at < 4 * SplatChunk::kCapacity; at += kLine) {
        __builtin_prefetch(bin.chunk->place + at, 1);
        __builtin_prefetch(bin.chunk->facing + at, 1);
    }
}

void TileBins::end_task(std::vector<TileRun>& runs) {
    for (const uint32_t tile : used_) {
        const Bin bin = std::exchange(bins_[tile], {});
        runs.push_back({tile, bin.count, bin.chunk, bin.colours});
    }
    used_.clear();
}

}  // namespace render
