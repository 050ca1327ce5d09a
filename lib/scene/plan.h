// How many bytes a view will need, estimated from what of its models is there: within a third where
// kPlanBytes of each are, in the order in which the view needs them.  (Of the whole dragon 5 % too many at
// most, of the same surface with 16 times as many vertices 7 % too few to 20 % too many.)
#pragma once

#include <span>
#include <string>

#include "core/json.h"
#include "scene/lacks.h"

namespace scene {

inline constexpr uint64_t kPlanBytes = 64 * 1024;

struct Plan {
    uint64_t file_bytes = 0;
    uint64_t present_bytes = 0;  // of blocks that the view needs and that are there
    uint64_t missing_bytes = 0;  // that will have to be fetched: an estimate, but for 0
};

// Of a view that was drawn, and no other, for which `lacks` were found.
Plan plan_of(std::span<const PlacedModel> models, std::span<const Lack> lacks, const splat::CutOptions& cut);

std::string to_text(const Plan& plan);
core::Json to_json(const Plan& plan);

}  // namespace scene
