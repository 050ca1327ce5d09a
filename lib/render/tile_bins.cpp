#include "render/tile_bins.h"

namespace render {

void TileBins::begin(int tiles_across, int tiles_down) {
    tiles_across_ = tiles_across;
    bins_.assign(size_t(tiles_across) * size_t(tiles_down), Bin{});
    used_.clear();
    chunks_taken_ = 0;
}

SplatChunk* TileBins::take_chunk() {
    const size_t slab = chunks_taken_ / kSlab;
    if (slab == slabs_.size()) slabs_.push_back(std::make_unique<SplatChunk[]>(kSlab));
    return &slabs_[slab][chunks_taken_++ % kSlab];
}

void TileBins::refill(uint32_t tile, Bin& bin, std::vector<TileRun>& runs) {
    if (bin.chunk)
        runs.push_back({tile, bin.count, bin.chunk});
    else
        used_.push_back(tile);
    bin = {take_chunk(), 0};
    // Its lines are the last frame's and far away by now: ask for all before the first is written.
    constexpr uint32_t kLine = 16;
    for (uint32_t at = 0; at < 4 * SplatChunk::kCapacity; at += kLine) {
        __builtin_prefetch(bin.chunk->place + at, 1);
        __builtin_prefetch(bin.chunk->facing + at, 1);
    }
}

void TileBins::end_task(std::vector<TileRun>& runs) {
    for (const uint32_t tile : used_) {
        runs.push_back({tile, bins_[tile].count, bins_[tile].chunk});
        bins_[tile] = {};
    }
    used_.clear();
}

}  // namespace render
