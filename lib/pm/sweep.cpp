#include "pm/sweep.h"

#include <algorithm>
#include <limits>

#include "pm/replica.h"
#include "pm/sent_tree.h"

namespace pm {

template <class Tree>
Sweep<Tree>::Sweep(const Tree& tree, const View& view, const Placement& placement, Culling culling)
    : tree_(tree), test_(view, placement, culling) {
    find_wanted();
    find_candidates();
}

template <class Tree>
void Sweep<Tree>::find_wanted() {
    wanted_.resize(tree_.end_of_splits());
    // What a split depends on comes before it.
    tree_.for_each_split([&](uint32_t n) {
        const uint32_t parent = tree_.parent(n);
        wanted_[n] = (parent == kNone || wanted_[parent]) && are_needs_wanted(n) &&
                     verdict(tree_.bounds(n)) == Verdict::refine;
    });
}

template <class Tree>
void Sweep<Tree>::find_candidates() {
    std::vector<Entry> stack;
    const auto look_at = [&](uint32_t n, double above) {
        if (tree_.is_leaf(n)) return;
        if (tree_.is_split(n)) {
            if (wanted_[n]) stack.push_back({std::min(above, test_.screen_error(tree_.bounds(n))), n});
        } else if (are_needs_wanted(n) && verdict(tree_.bounds(n)) == Verdict::refine) {
            push(n, above);
        }
    };
    tree_.for_each_root([&](uint32_t n) { look_at(n, std::numeric_limits<double>::infinity()); });
    while (!stack.empty()) {
        const Entry entry = stack.back();
        stack.pop_back();
        for (const uint32_t child : tree_.children(entry.node)) look_at(child, entry.error);
    }
}

// A total order that both sides have, whatever the order in which splits were received.
template <class Tree>
bool Sweep<Tree>::comes_before(const Entry& a, const Entry& b) const {
    if (a.error != b.error) return a.error > b.error;
    const uint8_t of_a = tree_.error_code(a.node), of_b = tree_.error_code(b.node);
    if (of_a != of_b) return of_a > of_b;
    return tree_.precedes(a.node, b.node);
}

template <class Tree>
void Sweep<Tree>::push(uint32_t node, double error_of_path) {
    heap_.push_back({std::min(error_of_path, test_.screen_error(tree_.bounds(node))), node});
    std::push_heap(heap_.begin(), heap_.end(),
                   [this](const Entry& a, const Entry& b) { return comes_before(b, a); });
}

template <class Tree>
uint32_t Sweep<Tree>::current() {
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

template <class Tree>
void Sweep<Tree>::pop() {
    std::pop_heap(heap_.begin(), heap_.end(),
                  [this](const Entry& a, const Entry& b) { return comes_before(b, a); });
    heap_.pop_back();
}

template <class Tree>
void Sweep<Tree>::was_split() {
    const Entry entry = heap_.front();
    pop();
    wanted_.resize(tree_.end_of_splits());
    wanted_[entry.node] = true;
    for (const uint32_t child : tree_.children(entry.node))
        if (!tree_.is_leaf(child) && verdict(tree_.bounds(child)) == Verdict::refine)
            push(child, entry.error);
}

template <class Tree>
void Sweep<Tree>::comes_later() {
    later_.push_back(heap_.front().node);
    pop();
}

template <class Tree>
void Sweep<Tree>::learned_more() {
    const uint32_t node = heap_.front().node;
    if (is_still_wanted(node)) return comes_later();
    pop();
}

template <class Tree>
void Sweep<Tree>::is_skipped() {
    pop();
}

template <class Tree>
void Sweep<Tree>::cone_learned(uint32_t node) {
    if (!tree_.is_split(node)) return;
    wanted_[node] = false;
    has_cut_off_ = true;
}

// Of what lies below a cone that was learned during the sweep, the way up is looked at here, and what other
// nodes need at the next sweep.
template <class Tree>
bool Sweep<Tree>::is_still_wanted(uint32_t n) const {
    if (verdict(tree_.bounds(n)) != Verdict::refine || !are_needs_wanted(n)) return false;
    for (uint32_t up = tree_.parent(n); up != kNone; up = tree_.parent(up))
        if (!is_wanted(up)) return false;
    return true;
}

template class Sweep<Replica>;
template class Sweep<SentTree>;

}  // namespace pm
