// The triangles of one block of nodes: its runs, found by counting from where its header says the first one
// is.
#pragma once

#include <cstdint>
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
        uint64_t block;
        uint32_t offset;                    // in the block
        uint32_t first_leaf;                // of the block's leaves, in the order of their slots
        std::vector<glm::u32vec3> entries;  // of its triangles
    };

    // Finds the runs that are there.  Throws core::Error for a damaged block, for runs that do not fit into
    // it or name corners that they do not have, and for runs of other leaves than the block's.
    void open(const Model& model, const BlockView& nodes);
    bool is_open() const { return is_open_; }
    uint64_t number() const { return number_; }  // of the block of nodes

    uint32_t leaf_count() const { return leaf_count_; }
    const std::vector<PlacedRun>& runs() const { return runs_; }

    // Of the leaf in `slot`.
    Place find(uint32_t slot) const {
        const uint32_t leaf = leaf_of_[slot];
        for (uint32_t r = 0; r < runs_.size(); ++r)
            if (leaf - runs_[r].first_leaf < runs_[r].run.triangles()) return {r, leaf - runs_[r].first_leaf};
        return {};
    }

  private:
    bool is_open_ = false;
    uint64_t number_ = 0;
    uint32_t leaf_count_ = 0;
    std::vector<uint16_t> leaf_of_;  // by slot: leaves before it
    std::vector<PlacedRun> runs_;
};

}  // namespace splat
