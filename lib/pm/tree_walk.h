// The nodes that a client has and that are not split, in the order of the tree: what a server and a client
// both have, so that a bit for each of them is enough to name some.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "pm/format.h"

namespace pm {

// `Tree` as in sweep.h.
template <class Tree>
class TreeWalk {
  public:
    // `tree` outlives it.  Leaves of the model are among the nodes.
    explicit TreeWalk(const Tree& tree) : tree_(&tree) {
        tree.for_each_root([&](uint32_t n) { stack_.push_back({n, 0}); });
        std::reverse(stack_.begin(), stack_.end());
        descend();
    }

    bool is_at_end() const { return stack_.empty(); }
    uint32_t current() const { return stack_.back().node; }
    // Of current(): is it a child of what was split during this walk, the kept one (1), the new one (2), or
    // none (0)?
    size_t age() const { return stack_.back().age; }
    // current() stays as it is; the next one is current
    void leave() {
        stack_.pop_back();
        descend();
    }
    // The tree was told a split of current(); its kept child is current.
    void was_split() { push_children(1, 2); }

  private:
    struct Entry {
        uint32_t node;
        uint8_t age;
    };
    void push_children(uint8_t age_of_kept, uint8_t age_of_new) {
        const auto [kept, fresh] = tree_->children(stack_.back().node);
        stack_.back() = {fresh, age_of_new};
        stack_.push_back({kept, age_of_kept});
    }
    void descend() {
        while (!stack_.empty() && tree_->is_split(stack_.back().node)) push_children(0, 0);
    }

    const Tree* tree_;
    std::vector<Entry> stack_;
};

}  // namespace pm
