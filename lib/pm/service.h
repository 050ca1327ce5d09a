// What a client asks of a server: pm-protocol(5).
//
// Kim, Lee, Kobbelt, section 5, and the two variations that section 6.3 discusses.
#pragma once

#include <cstdint>

namespace pm {

enum class Service : uint8_t {
    // The client says what it looks at, and is sent what it needs to refine and to coarsen by itself.
    selective,
    // The client says what it looks at, and is sent splits without bounds: it never coarsens, and cannot know
    // what it lacks.
    one_way,
    // The client says which nodes it wants split.  It knows no cones, so it asks for what shows its back too.
    lists,
};

constexpr bool tells_bounds(Service service) {
    return service != Service::one_way;
}

}  // namespace pm
