// Walking a model in the order of the file: breadth-first, each sibling group once, decoded.
//
// A group's place follows from the sizes of those before it, so every pointer is held against the place
// that the order gives: a walk that ends has read each group of the blocks exactly once.
#pragma once

#include <cstdint>
#include <functional>

#include "splat/model.h"

namespace splat {

// The places of groups, one after the other: a group that does not fit whole begins the next block.
class GroupCursor {
  public:
    explicit GroupCursor(uint32_t capacity) : capacity_(capacity) {}
    GroupAt place(uint32_t count) {
        if (slot_ + count > capacity_) ++block_, slot_ = 0;
        const GroupAt at{block_, slot_};
        slot_ += count;
        return at;
    }
    uint64_t block() const { return block_; }
    uint32_t slot() const { return slot_; }  // the next one

  private:
    uint32_t capacity_;
    uint64_t block_ = 0;
    uint32_t slot_ = 0;
};

struct WalkedNode {
    GroupAt at;        // where the node itself stands
    uint32_t level;    // 1 for the root's children
    const Node& node;  // model units
    const Node& parent;
    bool lacks_children;  // it has some, but the file ends before them
};

// Calls use(node) for the nodes of levels 1 to `last_level` that are there.  Memory: 64 bytes for each
// inner node of a level.  Throws core::Error "<name>: block 7 at byte 8192: ..." for a damaged block, for a
// group that is not where the order puts it, for a block that holds nodes which no group claims, and for
// more levels than the header says.
void walk(const Model& model, uint32_t last_level, const std::function<void(const WalkedNode&)>& use);

// Calls use(node) for what stands for the whole surface at a level: its nodes (0: the root), the leaves above
// it, and of a prefix the nodes above it whose children are not there.  In the order of the file.
void walk_cut(const Model& model, uint32_t level, const std::function<void(const Node&)>& use);

}  // namespace splat
