// What a view wants split of a whole model: a closed set that depends on the view alone.
#pragma once

#include <cstdint>
#include <vector>

#include "pm/model.h"
#include "pm/view.h"

namespace pm {

// Why refinement stops, counted by node that is tested.
struct SelectionCounts {
    uint64_t tested = 0;
    uint64_t accurate = 0, outside = 0, faces_away = 0;
    uint64_t blocked = 0;  // by a detail that it needs and that is not wanted
};

// A detail is wanted iff its own node's verdict is `refine`, and its parent and its needs are wanted (or
// none).
class Selection {
  public:
    explicit Selection(const Model& model) : model_(model) {}

    // The details wanted, rising.  Visits those and their children only.  Valid until the next call.
    const std::vector<uint32_t>& select(const View& view, Culling culling = Culling::on);
    const SelectionCounts& counts() const { return counts_; }  // of the last call

  private:
    const Model& model_;
    std::vector<uint32_t> wanted_, heap_;
    std::vector<uint8_t> is_wanted_;  // by detail, all 0 between calls
    SelectionCounts counts_;
};

}  // namespace pm
