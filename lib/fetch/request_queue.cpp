#include "fetch/request_queue.h"

#include <algorithm>
#include <numeric>

namespace fetch {

void RequestQueue::replace(std::vector<Want> wants) {
    std::sort(wants.begin(), wants.end(), [](const Want& a, const Want& b) {
        return a.block != b.block ? a.block < b.block : a.priority > b.priority;
    });
    const auto is_same = [](const Want& a, const Want& b) { return a.block == b.block; };
    wants.erase(std::unique(wants.begin(), wants.end(), is_same), wants.end());
    wants_ = std::move(wants);
    order_.resize(wants_.size());
    std::iota(order_.begin(), order_.end(), 0u);
    std::stable_sort(order_.begin(), order_.end(),
                     [&](uint32_t a, uint32_t b) { return wants_[a].priority > wants_[b].priority; });
    next_ = 0;
    left_ = wants_.size();
}

float RequestQueue::head_priority() const {
    return is_empty() ? 0 : wants_[order_[next_]].priority;
}

BlockRange RequestQueue::take(const Joining& joining) {
    const size_t head = order_[next_];
    size_t begin = head, end = head + 1;
    const auto join = [&](uint32_t most, float least) {
        // Onwards first: what follows in the file is what a prefix needs.
        while (end - begin < most && may_join(end, wants_[end - 1].block + 1, least)) ++end;
        while (end - begin < most && begin > 0 && may_join(begin - 1, wants_[begin].block - 1, least))
            --begin;
    };
    join(joining.most, wants_[head].priority * joining.alike);
    join(std::min(joining.most, joining.least), 0);
    const BlockRange range{wants_[begin].block, uint32_t(end - begin)};
    for (size_t i = begin; i != end; ++i) wants_[i].priority = -1;
    left_ -= range.count;
    while (next_ < order_.size() && is_taken(wants_[order_[next_]])) ++next_;
    return range;
}

}  // namespace fetch
