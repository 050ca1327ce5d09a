// The triangles of one block of nodes: its runs, found by counting from where its header says the first one
// is.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "splat/model.h"
#include "splat/triangle_run.h"

namespace splat {

class BlockTriangles {
  public:
    // Where a leaf's triangle is; run == kNone: in a block of triangles that is not there.
    struct Place {
        static constexpr uint32_t kNone = ~0u;
        uint32_t run = kNone, triangle = 0;
    };
    // A run, and where it stands.
    struct PlacedRun {
        TriangleRun run;
        uint64_t at;                      // byte of all runs
        uint64_t first_block, end_block;  // that hold it
        uint32_t first_leaf;              // of the block's leaves, in the order of their slots
    };

    // Reads the runs that are there.  Throws core::Error for a damaged block or run, and for runs of other
    // leaves than the block's.
    void open(const Model& model, const BlockView& nodes);
    bool is_open() const { return is_open_; }
    uint64_t number() const { return number_; }  // of the block of nodes

    // Whether runs were not there when it was opened that may be by now.
    bool is_out_of_date(const Model& model) const { return lacks_ && stock_ != model.stock(); }
    // Where the next run would be: a block of triangles that is not there; nothing where all runs are.
    std::optional<uint64_t> lacks() const { return lacks_; }

    uint32_t leaf_count() const { return leaf_count_; }
    std::span<const PlacedRun> runs() const { return std::span(runs_).first(run_count_); }

    // Of the leaf in `slot`.
    Place find(uint32_t slot) const {
        const uint32_t leaf = leaf_of_[slot];
        for (uint32_t r = 0; r < run_count_; ++r)
            if (leaf - runs_[r].first_leaf < runs_[r].run.triangles()) return {r, leaf - runs_[r].first_leaf};
        return {};
    }

  private:
    bool gather(const Model& model, uint64_t at, size_t count);

    bool is_open_ = false;
    uint64_t number_ = 0;
    uint32_t leaf_count_ = 0, stock_ = 0;
    std::optional<uint64_t> lacks_;
    std::vector<uint16_t> leaf_of_;  // by slot: leaves before it
    std::vector<PlacedRun> runs_;    // the first run_count_; others keep their memory
    size_t run_count_ = 0;
    std::vector<std::byte> bytes_;  // of a run, and kRunReadAhead
};

}  // namespace splat
