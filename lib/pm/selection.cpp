#include "pm/selection.h"

#include <algorithm>
#include <functional>

namespace pm {

const std::vector<uint32_t>& Selection::select(const View& view, Culling culling) {
    const RefinementTest test(view, model_.header().placement, culling);
    const Hierarchy tree = model_.hierarchy();
    const auto children = model_.children();
    wanted_.clear();
    counts_ = {};
    is_wanted_.resize(tree.details(), 0);
    heap_.clear();
    for (const uint32_t d : model_.root_split())
        if (d != kNone) heap_.push_back(d);
    // Smallest number first: what a detail needs stands before it, and so do the ancestors of that.
    std::make_heap(heap_.begin(), heap_.end(), std::greater<>());
    const auto push = [&](uint32_t d) {
        if (d == kNone) return;
        heap_.push_back(d);
        std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
    };
    while (!heap_.empty()) {
        std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
        const uint32_t d = heap_.back();
        heap_.pop_back();
        ++counts_.tested;
        const Verdict verdict = test(model_.bounds(d));
        counts_.accurate += verdict == Verdict::accurate;
        counts_.outside += verdict == Verdict::outside;
        counts_.faces_away += verdict == Verdict::faces_away;
        if (verdict != Verdict::refine) continue;
        if (tree.needs[d] != kNone && !is_wanted_[tree.needs[d]]) {
            ++counts_.blocked;
            continue;
        }
        is_wanted_[d] = 1;
        wanted_.push_back(d);
        push(children[d].kept);
        push(children[d].fresh);
    }
    for (const uint32_t d : wanted_) is_wanted_[d] = 0;
    return wanted_;
}

}  // namespace pm
