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
}

void TileBins::end_task(std::vector<TileRun>& runs) {
    for (const uint32_t tile : used_) {
        runs.push_back({tile, bins_[tile].count, bins_[tile].chunk});
        bins_[tile] = {};
    }
    used_.clear();
}

}  // namespace render
