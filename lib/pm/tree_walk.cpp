#include "pm/tree_walk.h"

namespace pm {

TreeWalk::TreeWalk(const Replica& replica) : replica_(&replica) {
    for (uint32_t root = replica.vertex_count() - replica.split_count(); root-- > 0;) stack_.push_back(root);
    descend();
}

void TreeWalk::leave() {
    stack_.pop_back();
    descend();
}

void TreeWalk::was_split() {
    descend();
}

void TreeWalk::descend() {
    while (!stack_.empty() && replica_->node(stack_.back()).split != kNone) {
        const uint32_t kept = replica_->node(stack_.back()).kept_child;
        stack_.back() = kept + 1;
        stack_.push_back(kept);
    }
}

}  // namespace pm
