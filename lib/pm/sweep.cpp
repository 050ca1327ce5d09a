#include "pm/sweep.h"

#include <algorithm>
#include <limits>

namespace pm {

Sweep::Sweep(const Replica& replica, const View& view, Culling culling)
    : replica_(replica), test_(view, replica.header().placement, culling) {
    const uint32_t splits = replica.split_count();
    wanted_.assign(splits, 0);
    path_error_.assign(splits, 0);
    const auto is_split_wanted = [&](uint32_t node) {
        const uint32_t split = node == kNone ? kNone : replica_.node(node).split;
        return split != kNone && wanted_[split] != 0;
    };
    // What a split depends on was received before it.
    const auto look_at = [&](uint32_t n) {
        const Node& node = replica_.node(n);
        const double above = node.parent == kNone ? std::numeric_limits<double>::infinity()
                                                  : path_error_[replica_.node(node.parent).split];
        if (node.is_leaf || (node.needs != kNone && !is_split_wanted(node.needs)) ||
            verdict(replica_.bounds(node)) != Verdict::refine)
            return;
        if (node.split == kNone) return push(n, above);
        wanted_[node.split] = 1;
        path_error_[node.split] = std::min(above, screen_error(node));
    };
    // What a node that is not split needs may be split by any later one: those come last.
    const uint32_t roots = replica.vertex_count() - splits;
    for (uint32_t s = 0; s != splits; ++s) {
        const uint32_t n = replica.node_of_split(s), parent = replica.node(n).parent;
        if (parent == kNone || is_split_wanted(parent)) look_at(n);
    }
    for (uint32_t n = 0; n != roots; ++n)
        if (replica.node(n).split == kNone) look_at(n);
    for (uint32_t s = 0; s != splits; ++s) {
        if (wanted_[s] == 0) continue;
        const uint32_t kept = replica.node(replica.node_of_split(s)).kept_child;
        for (const uint32_t n : {kept, kept + 1})
            if (replica.node(n).split == kNone) look_at(n);
    }
}

// A total order that both sides have, whatever the order in which splits were received.
bool Sweep::comes_before(const Entry& a, const Entry& b) const {
    if (a.error != b.error) return a.error > b.error;
    const Node &x = replica_.node(a.node), &y = replica_.node(b.node);
    if (x.error != y.error) return x.error > y.error;
    return replica_.precedes(a.node, b.node);
}

void Sweep::push(uint32_t node, double error_of_path) {
    heap_.push_back({std::min(error_of_path, screen_error(replica_.node(node))), node});
    std::push_heap(heap_.begin(), heap_.end(),
                   [this](const Entry& a, const Entry& b) { return comes_before(b, a); });
}

uint32_t Sweep::current() {
    for (;;) {
        if (heap_.empty()) {
            std::vector<uint32_t> again;
            again.swap(later_);
            for (const uint32_t n : again) push(n, std::numeric_limits<double>::infinity());
            if (heap_.empty()) return kNone;
        }
        if (!has_cut_off_ || is_still_wanted(heap_.front().node)) return heap_.front().node;
        pop();
    }
}

void Sweep::pop() {
    std::pop_heap(heap_.begin(), heap_.end(),
                  [this](const Entry& a, const Entry& b) { return comes_before(b, a); });
    heap_.pop_back();
}

void Sweep::was_split() {
    const Entry entry = heap_.front();
    pop();
    const Node& node = replica_.node(entry.node);
    wanted_.push_back(1);
    path_error_.push_back(entry.error);
    for (const uint32_t n : {node.kept_child, node.kept_child + 1}) {
        const Node& child = replica_.node(n);
        if (!child.is_leaf && verdict(replica_.bounds(child)) == Verdict::refine) push(n, entry.error);
    }
}

void Sweep::comes_later() {
    later_.push_back(heap_.front().node);
    pop();
}

void Sweep::learned_more() {
    const uint32_t node = heap_.front().node;
    if (is_still_wanted(node)) return comes_later();
    pop();
}

void Sweep::is_skipped() {
    pop();
}

void Sweep::cone_learned(uint32_t node) {
    const uint32_t split = replica_.node(node).split;
    if (split == kNone) return;
    wanted_[split] = 0;
    has_cut_off_ = true;
}

// Of what lies below a cone that was learned during the sweep, the way up is looked at here, and what other
// nodes need at the next sweep.
bool Sweep::is_still_wanted(uint32_t n) const {
    const Node& node = replica_.node(n);
    if (verdict(replica_.bounds(node)) != Verdict::refine) return false;
    if (node.needs != kNone) {
        const uint32_t needed = replica_.node(node.needs).split;
        if (needed == kNone || wanted_[needed] == 0) return false;
    }
    for (uint32_t up = node.parent; up != kNone; up = replica_.node(up).parent)
        if (wanted_[replica_.node(up).split] == 0) return false;
    return true;
}

}  // namespace pm
