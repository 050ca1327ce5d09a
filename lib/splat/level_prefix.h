// How much of a model's file its first levels take, told from the beginning of the file alone: levels stand
// one behind the other, and where one ends is told by the first node of the one before.
#pragma once

#include <cstdint>

#include "splat/model.h"

namespace splat {

struct LevelPrefix {
    bool is_known = false;
    // From the beginning of the file: where it is known, what levels 1 to `levels` take; where not, a larger
    // prefix that tells more.
    uint64_t bytes = 0;
    uint64_t blocks = 0;  // the same, in blocks from the first one on
};

// `prefix`: a model of which the first blocks are there.  Of a compressed one, what is not known yet is
// guessed from the mean size of a block.  Throws core::Error for a damaged block, and for levels that do not
// follow each other.
LevelPrefix level_prefix(const Model& prefix, uint32_t levels);

}  // namespace splat
