// Any bytes as a message of client or server, as they are and with the checksum set right: a message whose
// bytes come back the same, and an image of the size that it says; or Error.  Nothing else.
#include <xxhash.h>

#include <cmath>
#include <cstring>
#include <variant>
#include <vector>

#include "core/error.h"
#include "ppve/elimination.h"
#include "ppve/messages.h"
#include "require.h"

namespace {

// A mutation may ask for an image of any size: only small ones are decoded, for speed.
constexpr size_t kMostPixels = 1 << 16;

void use(std::span<const std::byte> bytes) {
    try {
        const ppve::Message message = ppve::parse(bytes, "fuzz");
        const auto again = ppve::format(message);
        require(std::equal(again.begin(), again.end(), bytes.begin(), bytes.end()),
                "a message is written as it was read");
        const auto* answer = std::get_if<ppve::Answer>(&message);
        if (answer == nullptr) return;
        const geom::View& v = answer->frustum.view;
        if (size_t(v.width) * size_t(v.height) > kMostPixels) return;
        ppve::read_removals(answer->replaced, kMostPixels);
        const ppve::DepthImage image = ppve::image_of(*answer);
        require(image.depth.size() == image.pixels(), "an image has the size of its frustum");
        for (size_t p = 0; p < image.pixels(); ++p)
            if (image.depth[p] != 0)
                require(std::isfinite(image.coding.depth(image.depth[p])), "depths are finite");
    } catch (const core::Error&) {
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    std::vector<std::byte> bytes(size);
    if (size > 0) std::memcpy(bytes.data(), data, size);
    use(bytes);
    if (size < sizeof(uint64_t)) return 0;
    const uint64_t sum = XXH3_64bits(bytes.data(), size - sizeof(sum));
    std::memcpy(bytes.data() + size - sizeof(sum), &sum, sizeof(sum));
    use(bytes);
    return 0;
}
