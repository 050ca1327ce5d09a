// The nodes of a replica that are not split, in the order of the tree: what a server and a client both have,
// so that a bit for each of them is enough to name some.
#pragma once

#include <cstdint>
#include <vector>

#include "pm/replica.h"

namespace pm {

class TreeWalk {
  public:
    // `replica` outlives it.  Leaves of the model are among the nodes.
    explicit TreeWalk(const Replica& replica);

    uint32_t current() const { return stack_.empty() ? kNone : stack_.back(); }  // kNone at the end
    void leave();      // current() stays as it is; the next one is current
    void was_split();  // the replica was told a split of current(); its kept child is current

  private:
    void descend();

    const Replica* replica_;
    std::vector<uint32_t> stack_;
};

}  // namespace pm
