// Which blocks to ask for next, of one file: the merged queues of its clients, cut into ranges.
//
// Neighbours are joined into one range only while their priorities are alike: joining "because they are
// there" throws the order away, and costs two to four times the bytes to a given picture (in simulation,
// with sums of pixels times error as priorities).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace fetch {

struct Want {
    uint32_t block;
    float priority;  // finite, at least 0; more is sooner
};

struct BlockRange {
    uint32_t first, count;
};

// Not thread-safe.
class RequestQueue {
  public:
    // Replaces all.  A block that is there several times counts with its highest priority.
    void replace(std::vector<Want> wants);
    bool is_empty() const { return left_ == 0; }
    // The highest priority, of those left; 0 where none is.
    float head_priority() const;
    // Takes out the block of the highest priority (of equal ones the first in the file), and of its
    // neighbours up to `most` blocks in all whose priority is at least `alike` times its own.  The queue must
    // not be empty.
    BlockRange take(uint32_t most, float alike);
    // The blocks that are left, in the order of the file.
    template <class Body>
    void for_each(const Body& body) const {
        for (const Want& want : wants_)
            if (!is_taken(want)) body(want.block);
    }

  private:
    static bool is_taken(const Want& want) { return want.priority < 0; }
    bool may_join(size_t i, uint32_t block, float least) const {
        return i < wants_.size() && wants_[i].block == block && wants_[i].priority >= least;
    }

    std::vector<Want> wants_;      // by block; the priority of one that was taken is -1
    std::vector<uint32_t> order_;  // positions in wants_, by priority
    size_t next_ = 0;              // in order_: those before it are taken
    size_t left_ = 0;
};

}  // namespace fetch
