// In which order to ask for the blocks that a picture lacks.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "scene/lacks.h"

namespace scene {

// gain: by the pixels that a node owns times its projected error, summed over the nodes that wait for the
// block; what
//     owns no pixel is not asked for.
// The others are those of Streaming QSplat, section 4.2; a block comes when the first of its nodes does:
// level: from root to leaves.  radius: in object space, the largest first.  screen: the same on the screen.
// y: from the top of the picture down.
// sweep: from the top down, again and again, each time what is wider than 1/sweep_base of the time before.
enum class Order { gain, level, radius, screen, y, sweep };

struct OrderOptions {
    Order order = Order::gain;
    double sweep_base = 1.4142135623730951;  // above 1
    std::optional<Magnifier> magnifier{};
};

struct BlockRequest {
    size_t model;
    uint64_t block;
    float priority;  // > 0 and finite; blocks that are alike in their order are within a factor of 3
};

// One for each block, the most urgent first, blocks in the order of the file where they are equally so.
// `picture_height`: pixels.
std::vector<BlockRequest> requests_for(std::span<const Lack> lacks, const OrderOptions& options,
                                       int picture_height);

// For what owns no pixel, once nothing else is missing: the largest errors first.
std::vector<BlockRequest> requests_for_hidden(std::span<const Lack> lacks);

}  // namespace scene
