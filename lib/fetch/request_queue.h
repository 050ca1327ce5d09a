// Which blocks to ask for next, of one file: the merged queues of its clients, cut into ranges.
//
// Neighbours are joined into one range only while their priorities are alike: joining "because they are
// there" throws the order away, and costs two to four times the bytes to a given picture (in simulation,
// with sums of pixels times error as priorities).  But where a range must be longer for the few that may be
// under way to fill a link, it is: an idle link costs more than the order.
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

// Nobody waits for what has less than this.
constexpr float kIdlePriority = 1e-20f;

struct BlockRange {
    uint32_t first, count;
};

struct Joining {
    uint32_t most = 1;   // blocks, at least 1
    float alike = 1;     // the least priority of a neighbour, as a factor of the first one's
    uint32_t least = 1;  // blocks up to which neighbours are taken whatever their priority
};

// Not thread-safe.
class RequestQueue {
  public:
    // Replaces all.  A block that is there several times counts with its highest priority.
    void replace(std::vector<Want> wants);
    bool is_empty() const { return left_ == 0; }
    // The highest priority, of those left; 0 where none is.
    float head_priority() const;
    // Takes out the block of the highest priority (of equal ones the first in the file), and with it
    // neighbours.  The queue must not be empty.
    BlockRange take(const Joining& joining);
    // The blocks that are left, in the order of the file.
    template <class Body>
    void for_each(const Body& body) const {
        for (const Want& want : wants_)
            if (!is_taken(want)) body(want.block);
    }

  private:
    static bool is_taken(const Want& want) { return want.priority < 0; }
    bool may_join(size_t i, uint32_t block, float least) const {
        return i < wants_.size() && wants_[i].block == block && !is_taken(wants_[i]) &&
               wants_[i].priority >= least;
    }

    std::vector<Want> wants_;      // by block; the priority of one that was taken is -1
    std::vector<uint32_t> order_;  // positions in wants_, by priority
    size_t next_ = 0;              // in order_: those before it are taken
    size_t left_ = 0;
};

}  // namespace fetch
