// Sorting splats into the tiles of the screen as they come.
//
// Each tile has a bin, a list of chunks that are filled one after the other.  Several threads have bins of
// their own, which they lend to one task at a time; what a task put into them stays until the next frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace render {

// 230,000 splats of 3 px, smooth: 5.6 ms; tiles of 64 x 64 6.2 ms, of 32 x 32 6.5 ms.
inline constexpr int kTileWidth = 64;
inline constexpr int kTileHeight = 32;

// Splats as they came, four floats of each together.
struct SplatChunk {
    static constexpr uint32_t kCapacity = 64;  // a multiple of every vector length
    alignas(64) float place[4 * kCapacity];    // x, y, z, radius
    alignas(64) float facing[4 * kCapacity];   // normal, flatness
    alignas(64) uint32_t colour[kCapacity];    // where the splats have colour
};

// The first `count` splats of a chunk, which may lie in `tile`, tiles being counted row by row.
struct TileRun {
    uint32_t tile, count;
    const SplatChunk* chunk;
};

class TileBins {
  public:
    // Starts a frame; chunks of the last one are used again.
    void begin(int tiles_across, int tiles_down);

    int tiles_across() const { return tiles_across_; }

    // Where the task's next splat in a tile goes.  `runs` get the chunks that are full.
    struct Place {
        SplatChunk* chunk;
        uint32_t at;
    };
    Place next(uint32_t tile, std::vector<TileRun>& runs) {
        Bin& bin = bins_[tile];
        if (bin.count == SplatChunk::kCapacity) refill(tile, bin, runs);
        return {bin.chunk, bin.count++};
    }

    // Ends a task: `runs` get the other chunks.  Of each tile the runs are in the order of their splats.
    void end_task(std::vector<TileRun>& runs);

  private:
    static constexpr size_t kSlab = 64;  // chunks allocated at a time

    struct Bin {
        SplatChunk* chunk = nullptr;
        uint32_t count = SplatChunk::kCapacity;  // so that the first splat asks for a chunk
    };
    void refill(uint32_t tile, Bin& bin, std::vector<TileRun>& runs);
    SplatChunk* take_chunk();

    int tiles_across_ = 0;
    std::vector<Bin> bins_;
    std::vector<uint32_t> used_;  // the task's tiles
    std::vector<std::unique_ptr<SplatChunk[]>> slabs_;
    size_t chunks_taken_ = 0;
};

}  // namespace render
