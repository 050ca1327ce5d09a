// Leaves that are handed out as triangles: their corners, decoded once a run and view.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "geom/triangle_batch.h"
#include "splat/cut/cut_groups.h"
#include "splat/cut/triangle_view.h"
#include "splat/triangle_reader.h"

namespace splat {

// What a thread keeps between tasks and frames.
class CutTriangles {
  public:
    geom::TriangleBatch batch;

    // Nothing is in the batch any more, and no run is seen by another view.
    void begin() { batch.count = 0, seen_block_ = ~uint64_t(0); }

    const BlockTriangles& open(const Model& model, const BlockView& block) {
        BlockTriangles& found = opened_[block.number() % kOpened];
        if (!found.is_open() || found.number() != block.number() || found.is_out_of_date(model))
            found.open(model, block);
        return found;
    }

    // Appends the chunk's triangles to the batch, which has room for them.  `touch` is told of the blocks of
    // triangles that are used.
    void add(const Model& model, const BlockView& block, const Chunk& chunk, const CutView& view,
             const std::function<void(uint64_t)>& touch);

  private:
    static constexpr size_t kOpened = 4;

    std::array<BlockTriangles, kOpened> opened_;  // by number modulo this
    RunInView seen_;                              // the run that the last triangle was taken from
    uint64_t seen_block_ = ~uint64_t(0);          // of nodes
    uint32_t seen_run_ = 0;
};

}  // namespace splat
