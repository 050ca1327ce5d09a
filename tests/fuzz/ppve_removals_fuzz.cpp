// Any bytes: a list of removed points of at most as many as were said, or core::Error; and what is read fits
// a tree, or is refused by it.
#include <cstddef>
#include <cstdint>

#include "core/error.h"
#include "ppve/elimination.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    constexpr uint64_t kMostPoints = 10000;
    try {
        ppve::Change change;
        change.removed = ppve::read_removals({reinterpret_cast<const std::byte*>(data), size}, kMostPoints);
        uint64_t points = 0;
        for (const ppve::Removal& removal : change.removed) points += removal.is_removed.size();
        require(points <= kMostPoints, "memory is bounded by the points that there are");
        ppve::Octree(ppve::TreeShape{}).apply(change);
    } catch (const core::Error&) {
    }
    return 0;
}
